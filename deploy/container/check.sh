#!/usr/bin/env bash
# Builds both images of the Dockerfile without Docker and runs them: a base image of Debian 12 from the machine's own mirror,
# buildah, podman. Prints their sizes, and fails when `server` has more than 120 MB above its base. Each container has a read-only
# root file system, no capabilities and no network but its own loopback; it fits a synthetic capture, is told to end, and a second
# one on the same volume hands the same frames out again.
#   deploy/container/check.sh [--cache DIR] [--scratch DIR]
# --cache keeps the base image and ccache's folder for the next run. Everything else lies in a folder of its own below --scratch
# (default $TMPDIR or /tmp; about 10 GB) and is removed at the end. Needs root.
set -euo pipefail

limit_mb=120
drain_seconds=20
frames=12
root=$(cd "$(dirname "$0")/../.." && pwd)

fail() {
  echo "check: $*" >&2
  exit 1
}

install_packages() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  echo "check: installing ${missing[*]}" >&2
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# A root of Debian 12 as in Debian's own base images: no service is started in it, and dpkg does not wait for the disk.
make_base_root() {
  local options=() setting
  while read -r setting; do
    options+=("--aptopt=$setting")
  done < <(apt-config dump | grep -E '^Acquire::(Check-Date|Check-Valid-Until|https?::Proxy) ')
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT) $(ORIGIN)' 'Created-By: Packages' |
    sed -n 's/ Debian$//p' | grep -E '^deb [^ ]* bookworm' | sort -u >sources.list
  mmdebstrap --quiet --variant=apt --dpkgopt=force-unsafe-io "${options[@]}" \
    --customize-hook='printf "#!/bin/sh\nexit 101\n" >"$1/usr/sbin/policy-rc.d" && chmod +x "$1/usr/sbin/policy-rc.d"' \
    bookworm "$1" - <sources.list
}

make_base_image() {
  local container
  echo "making the base image"
  if [ ! -s "$cache/base.tar" ]; then
    make_base_root "$scratch/base.tar"
    mv "$scratch/base.tar" "$cache/base.tar"
  fi
  container=$(buildah from scratch)
  buildah add --quiet "$container" "$cache/base.tar" / >/dev/null
  buildah commit --quiet --rm --format docker "$container" localhost/base >/dev/null
}

build() {
  echo "building $1"
  buildah bud --isolation chroot --format docker --pull-never --layers --build-arg BASE=localhost/base \
    --target "$1" --tag "localhost/$1" "$root" >"$1.log" 2>&1 || { tail -n 60 "$1.log" >&2; fail "building $1 failed"; }
  grep -E 'tests passed|Total Test time' "$1.log" || true
}

mb() { podman image inspect --format '{{.Size}}' "localhost/$1" | awk '{ printf "%.1f", $1 / 1e6 }'; }

print_sizes() {
  local base server full
  base=$(mb base) server=$(mb server) full=$(mb full)
  awk -v base="$base" -v server="$server" -v full="$full" -v limit="$limit_mb" 'BEGIN {
    printf "base    %7.1f MB\nserver  %7.1f MB, %.1f MB above base (at most %d)\n", base, server, server - base, limit
    printf "full    %7.1f MB, %.1f MB above base\n", full, full - base
    exit server - base > limit
  }' || fail "server is too large"
  echo "largest files that server adds:"
  sed -n '/^What the image adds/,/^[0-9]*\t/p' server.log | sed -n 2,7p
}

# start IMAGE VOLUME: a server container, until the image's own health check calls it ready.
start() {
  local pid status health
  mapfile -t health < <(podman image inspect --format '{{range .HealthCheck.Test}}{{println .}}{{end}}' "localhost/$1" | grep .)
  [ "${health[0]}" = CMD ] || fail "the health check of $1 is no command without a shell"
  podman run --detach --name server --read-only --read-only-tmpfs=false --network none --cap-drop all \
    --security-opt no-new-privileges --no-healthcheck --volume "$2:/var/lib/cagefit" "localhost/$1" >/dev/null
  for _ in $(seq 100); do
    ! podman exec server "${health[@]:1}" >/dev/null 2>&1 || break
    sleep 0.2
  done
  podman exec server "${health[@]:1}" >/dev/null || { podman logs server >&2; fail "$1 does not become ready"; }

  pid=$(podman inspect --format '{{.State.Pid}}' server)
  status=$(</proc/"$pid"/status)
  grep -qE $'^Uid:\t10001\t10001\t10001\t10001$' <<<"$status" || fail "$1 does not run as user 10001"
  grep -qE $'^CapBnd:\t0+$' <<<"$status" || fail "$1 has capabilities"
  grep -qE '^[^ ]+ / [^ ]+ ro,' /proc/"$pid"/mounts || fail "the root file system of $1 is not read-only"
}

# client IMAGE ARGUMENT...: the image's cagefit in a container of its own, beside the server container.
client() {
  local image=$1
  shift
  podman run --rm --network "${network:-container:server}" --read-only --cap-drop all --no-healthcheck \
    --volume "$scratch/work:/shared" --entrypoint /usr/local/bin/cagefit "localhost/$image" "$@"
}

# Ends the server container by the image's stop signal.
stop() {
  local begin=$SECONDS code
  podman stop --time $((drain_seconds + 10)) server >/dev/null
  code=$(podman inspect --format '{{.State.ExitCode}}' server)
  [ "$code" -eq 0 ] || { podman logs server >&2; fail "the server ended with exit code $code"; }
  [ $((SECONDS - begin)) -le "$drain_seconds" ] || fail "the server took $((SECONDS - begin)) s to end"
  podman rm --volumes=false server >/dev/null
}

# `server` says why it makes no control mesh.
check_refusal() {
  ! client server fit /shared/capture --server 127.0.0.1:50051 --vertices 300 --out /shared/none >refusal.log 2>&1 ||
    fail "server makes a control mesh"
  grep -q 'template program' refusal.log || { cat refusal.log >&2; fail "server does not say that it makes no control mesh"; }
}

# Prints the session's id. Fails unless all frames are fitted.
read_report() {
  python3 - "$1" "$frames" <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
total = report["total"]
if total["fitted"] != int(sys.argv[2]) or total["frames"] != total["fitted"]:
    sys.exit(f"check: {total['fitted']} of {total['frames']} frames are fitted, {sys.argv[2]} were sent")
print(f"{total['fitted']} frames fitted, worst RMS distance {total['worst_rms_percent']:.4f} % of the diagonal", file=sys.stderr)
print(report["session"]["session_id"])
PY
}

# check_image IMAGE OPTION...: options of `cagefit fit` that say where the control mesh comes from.
check_image() {
  local image=$1 session frame
  shift
  echo "running $image"
  [ "$(podman image inspect --format '{{index .Labels "org.opencontainers.image.version"}}' "localhost/$image")" = \
    "$(podman run --rm --network none --no-healthcheck "localhost/$image" --version | awk '{ print $NF }')" ] ||
    fail "the label of $image has another version than its programs"

  start "$image" "cagefit-$image"
  client "$image" fit /shared/capture --server 127.0.0.1:50051 --keep-session --out "/shared/$image" "$@" >"$image.fit.log" 2>&1 ||
    { cat "$image.fit.log" >&2; podman logs server >&2; fail "the fit failed"; }
  session=$(read_report "work/$image/report.json")
  [ "$image" = full ] || check_refusal
  stop

  start "$image" "cagefit-$image"
  client "$image" session pull "$session" --frames "/shared/$image-pulled" >/dev/null
  stop
  for frame in "work/$image"/frames/*.obj; do
    cmp "$frame" "work/$image-pulled/$(basename "$frame")" || fail "a second container gives other frames"
  done
  echo "$image: became ready, fitted, ended on SIGTERM with 0; a second container gives the same frames"
}

check() {
  make_base_image
  build server
  build full
  print_sizes

  mkdir -m 0777 work
  network=none client full synth tube --out /shared/capture --frames "$frames" --points 20000 >/dev/null
  network=none client full template /shared/capture/frame_0000.drc --vertices 300 --out /shared/cage.obj >/dev/null
  check_image server --template /shared/cage.obj
  check_image full --vertices 300
  echo "Both images work."
}

# Everything happens in namespaces of its own, which take mounts, processes and containers with them when they end.
inside() {
  cd "$scratch"
  mount -t tmpfs tmpfs /dev/shm
  umount -l /sys/fs/cgroup/unified 2>/dev/null || true  # crun refuses cgroups of both versions side by side
  mkdir -p tmp/buildah-cache/root/.cache/ccache "$cache/ccache"
  mount --bind "$cache/ccache" tmp/buildah-cache/root/.cache/ccache  # where buildah 1.28 has the Dockerfile's cache mount
  export TMPDIR=$scratch/tmp CONTAINERS_STORAGE_CONF=$scratch/storage.conf CONTAINERS_CONF=$scratch/containers.conf
  check
}

write_configuration() {
  local driver=vfs limit probe=$scratch/probe
  mkdir -p "$probe"/{lower,upper,work,merged}
  ! unshare --mount mount -t overlay overlay -o "lowerdir=$probe/lower,upperdir=$probe/upper,workdir=$probe/work" \
    "$probe/merged" 2>/dev/null || driver=overlay
  cat >"$scratch/storage.conf" <<CONF
[storage]
driver = "$driver"
graphroot = "$scratch/storage"
runroot = "$scratch/run"
CONF
  limit=$(ulimit -Hn)
  cat >"$scratch/containers.conf" <<CONF
[containers]
cgroups = "disabled"
default_ulimits = ["nofile=1024:$limit", "nproc=4096:4096"]
[engine]
cgroup_manager = "cgroupfs"
events_logger = "none"
runtime = "crun"
tmp_dir = "$scratch/run/libpod"
[network]
network_config_dir = "$scratch/run/networks"
CONF
}

clean_up() {
  if [ -n "${process:-}" ]; then
    kill -KILL "$process" 2>/dev/null || true  # and so all that is inside
    wait "$process" || true
  fi
  rm -rf --one-file-system "$scratch"
}

scratch_parent=${TMPDIR:-/tmp} cache=""
while [ $# -gt 0 ]; do
  case $1 in
    --inside) scratch=$2 cache=$3; inside; exit ;;
    --cache) mkdir -p "$2"; cache=$(realpath "$2"); shift 2 ;;
    --scratch) mkdir -p "$2"; scratch_parent=$(realpath "$2"); shift 2 ;;
    *) echo "usage: check.sh [--cache DIR] [--scratch DIR]" >&2; exit 2 ;;
  esac
done
[ "$(id -u)" -eq 0 ] || fail "needs root, for mounts, namespaces and packages"

apt-get update -qq
install_packages buildah crun mmdebstrap podman python3
scratch=$(mktemp -d "$scratch_parent/cagefit-containers-XXXXXX")
trap 'exit 130' INT TERM
trap clean_up EXIT
write_configuration
unshare --mount --pid --ipc --fork --mount-proc --kill-child "$0" --inside "$scratch" "${cache:-$scratch/cache}" &
process=$!
wait "$process"
