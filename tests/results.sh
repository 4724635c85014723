#!/usr/bin/env bash
# Fits the real models, scans and sequences and prints the README's table of distances. Needs the test data ($CAGEFIT_DATA,
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

echo "| target | control vertices | RMS, % | max, % |"
echo "| --- | ---: | ---: | ---: |"
while read -r target vertices; do
  "$cagefit" fit "$data/$target" --vertices "$vertices" --out "$out/fit" --quick >/dev/null 2>&1
  "$cagefit" evaluate "$out/fit/cage.obj" "$data/$target" --json >"$out/distances.json"
  python3 - "$target" "$vertices" "$out/distances.json" <<'PY'
import json, sys
d = json.load(open(sys.argv[3]))[0]["distances"]["target_to_fit"]
print(f"| {sys.argv[1]} | {sys.argv[2]} | {d['rms_percent']:.4f} | {d['max_percent']:.2f} |")
PY
done <<'LIST'
static/bunny_closed_34835.ply 314
static/bunny_closed_34835.ply 4667
static/bunny_35947.ply 314
static/bunny_35947.ply 4667
static/face_25905.ply 1000
scans/bunny_72027_resampled.ply 2000
scans/bunny_raw_362272.ply 1000
LIST
while read -r sequence vertices; do
  "$cagefit" fit "$data/$sequence" --vertices "$vertices" --out "$out/fit" >/dev/null 2>&1
  python3 - "$sequence" "$vertices" "$out/fit/report.json" <<'PY'
import json, sys
report = json.load(open(sys.argv[3]))
total = report["total"]
largest = max(f["distances"]["max_percent"] for f in report["frames"])
print(f"| {sys.argv[1]}, worst of {total['fitted']} frames | {sys.argv[2]} | {total['worst_rms_percent']:.4f} | {largest:.2f} |")
PY
done <<'LIST'
tshirt/drc 2046
puppet/drc 1252
LIST
