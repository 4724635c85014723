#!/usr/bin/env bash
# Sets up, builds, starts cagefitd on a free port, streams a capture through it and prints what was reached; shows it in
# build/demo/fit/report.html, which any browser opens.
#   deploy/demo.sh                       a capture that it makes itself
#   deploy/demo.sh INPUT... [-- OPTION...]   files or a folder; options as of `cagefit fit`, e.g. -- --vertices 2046
# Files go to $CAGEFIT_DEMO_OUT (default build/demo). Exits 1 if a frame is missing or the RMS distance of any frame is above
# 0.2 % of the diagonal.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
inputs=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  inputs+=("$(realpath -- "$1")")
  shift
done
[ $# -eq 0 ] || shift
options=("$@")
case " ${options[*]-} " in
  *" --vertices"* | *" --template"*) ;;
  *) options+=(--vertices 1000) ;;
esac

cd "$root"
out=${CAGEFIT_DEMO_OUT:-$root/build/demo}
deploy/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target cagefit cagefitd
bin=$root/build/release/bin
mkdir -p "$out"

if [ ${#inputs[@]} -eq 0 ]; then
  rm -rf "$out/capture"
  "$bin/cagefit" synth tube --out "$out/capture"
  inputs=("$out/capture")
fi

"$bin/cagefitd" --listen 127.0.0.1:0 --store "sqlite:$out/sessions.db" >"$out/cagefitd.address" 2>"$out/cagefitd.log" &
server=$!
trap 'kill "$server" 2>/dev/null; wait "$server" 2>/dev/null || true' EXIT
for _ in $(seq 100); do
  address=$(sed -n 's/^listening on //p' "$out/cagefitd.address")
  [ -z "$address" ] || break
  kill -0 "$server" 2>/dev/null || { cat "$out/cagefitd.log" >&2; exit 1; }
  sleep 0.1
done
echo "cagefitd serves on $address"

rm -rf "$out/fit"
status=0
"$bin/cagefit" fit "${inputs[@]}" --server "$address" --out "$out/fit" --report "${options[@]}" || status=$?
grep VmHWM "/proc/$server/status" | awk '{ printf "Server memory at its highest: %.0f MB\n", $2 / 1024 }'
echo "Server log: $out/cagefitd.log"
echo "To look at: $out/fit/report.html"
[ "$status" -eq 0 ] || { echo "demo: cagefit fit ended with exit code $status" >&2; exit 1; }

python3 - "$out/fit/report.json" <<'PY'
import json, sys
total = json.load(open(sys.argv[1]))["total"]
missing = total["frames"] - total["fitted"]
worst = total["worst_rms_percent"]
if missing or worst > 0.2:
    sys.exit(f"demo: {missing} frames are missing, the worst RMS distance is {worst:.4f} % of the diagonal; allowed: 0 and 0.2 %")
PY
