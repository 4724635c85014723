#!/usr/bin/env bash
# Fits the real models, scans and sequences and prints the README's tables of distances. Needs the test data ($CAGEFIT_DATA,
# default ../shared/data).
set -euo pipefail
cd "$(dirname "$0")/.."
data=${CAGEFIT_DATA:-../shared/data}

deploy/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target cagefit >&2
cagefit=build/release/bin/cagefit
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Closed models both ways (the RMS of both, the larger maximum); others from the target alone.
echo "| target | control vertices | RMS, % | max, % | paper's settings: RMS, % | max, % |"
echo "| --- | ---: | ---: | ---: | ---: | ---: |"
while read -r target vertices ways options; do
  echo -n "| $target${options:+, $options} | $vertices |"
  for preset in default paper; do
    # shellcheck disable=SC2086
    "$cagefit" fit "$data/$target" --vertices "$vertices" --out "$out/fit" --quick --preset "$preset" $options \
      >/dev/null 2>&1
    "$cagefit" evaluate "$out/fit/cage.obj" "$data/$target" --json >"$out/distances.json"
    python3 - "$ways" "$out/distances.json" <<'PY'
import json, sys
d = json.load(open(sys.argv[2]))[0]["distances"]
sides = [d["target_to_fit"], d["fit_to_target"]][: int(sys.argv[1])]
rms = (sum(s["rms_percent"] ** 2 for s in sides) / len(sides)) ** 0.5
print(f" {rms:.4f} | {max(s['max_percent'] for s in sides):.2f} |", end="")
PY
  done
  echo
done <<'LIST'
static/bunny_closed_34835.ply 314 2
static/bunny_closed_34835.ply 4667 2
static/spot_11533.ply 800 2
static/armadillo_49990.ply 8000 2
static/fandisk_6475.ply 600 2
static/fandisk_6475.ply 600 2 --crease-angle 0
static/bunny_35947.ply 4667 1
static/face_25905.ply 1000 1
scans/bunny_72027_resampled.ply 2000 1
scans/bunny_raw_362272.ply 1000 1
scans/lion_takanawa_341989.ply 2000 1
LIST
echo
echo "| model | tolerance, % | control vertices |"
echo "| --- | ---: | ---: |"
while read -r target tolerance; do
  "$cagefit" fit "$data/$target" --tolerance "$tolerance%" --out "$out/fit" --quick >/dev/null 2>&1 || true
  python3 - "$target" "$tolerance" "$out/fit/report.json" <<'PY'
import json, sys
t = json.load(open(sys.argv[3]))["frames"][0]["tolerance"]
reached = "" if t["end"] == "TOLERANCE_END_WITHIN" else f" (no closer than {t['most_percent']:.3f} %)"
print(f"| {sys.argv[1]} | {sys.argv[2]} | {t['control_vertices']}{reached} |")
PY
done <<'LIST'
static/bunny_closed_34835.ply 0.2
static/bunny_closed_34835.ply 0.1
static/spot_11533.ply 0.2
static/spot_11533.ply 0.1
static/fandisk_6475.ply 0.2
static/fandisk_6475.ply 0.1
static/face_25905.ply 0.1
LIST
echo
echo "| sequence | control vertices | worst RMS, % | largest, % |"
echo "| --- | ---: | ---: | ---: |"
while read -r sequence vertices; do
  "$cagefit" fit "$data/$sequence" --vertices "$vertices" --out "$out/fit" >/dev/null 2>&1
  python3 - "$sequence" "$vertices" "$out/fit/report.json" <<'PY'
import json, sys
report = json.load(open(sys.argv[3]))
total = report["total"]
largest = max(f["distances"]["max_percent"] for f in report["frames"])
print(f"| {sys.argv[1]}, {total['fitted']} frames | {sys.argv[2]} | {total['worst_rms_percent']:.4f} | {largest:.2f} |")
PY
done <<'LIST'
tshirt/drc 2046
puppet/drc 1252
LIST
