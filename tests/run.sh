#!/usr/bin/env bash
# Sets up, builds and runs every test. Extra arguments go to ctest, e.g. tests/run.sh -R Imls.
# CAGEFIT_DATA names the folder of real models (default ../shared/data); CAGEFIT_REQUIRE_DATA=1 turns skips into failures.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release

log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
ctest --preset release --no-tests=error "$@" 2>&1 | tee "$log" | grep -v '^[0-9]*% tests passed' || status=${PIPESTATUS[0]}

skipped=$(grep -c '\*\*\*Skipped' "$log" || true)
echo "$skipped test(s) skipped for want of data"
grep '^[0-9]*% tests passed' "$log" || true
exit "$status"
