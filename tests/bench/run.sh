#!/usr/bin/env bash
# Builds and runs the benchmarks and prints the README's table: medians of five runs. Real data as for tests/run.sh, else the
# project's own captures. Extra arguments go to Google Benchmark, e.g. --benchmark_filter=Imls.
set -euo pipefail
cd "$(dirname "$0")/../.."

deploy/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target cagefit_bench >&2
result=$(mktemp)
trap 'rm -f "$result"' EXIT
build/release/bin/cagefit_bench --benchmark_repetitions=5 --benchmark_report_aggregates_only=true \
  --benchmark_out="$result" --benchmark_out_format=json "$@" >&2

python3 - "$result" <<'PY'
import json, sys
print("| what | median | on |\n| --- | ---: | --- |")
for run in json.load(open(sys.argv[1]))["benchmarks"]:
    if run.get("aggregate_name") != "median":
        continue
    name = run["run_name"].split("/")[0]
    time = f"{run['real_time']:.2f} ms"
    if "frames_per_second" in run:
        time = f"{run['frames_per_second']:.1f} frames/s"
    print(f"| {name} | {time} | {run.get('label', '')} |")
PY
