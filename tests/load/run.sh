#!/usr/bin/env bash
# Builds and runs a load program: tests/load/run.sh idle|active|overload [options]. Without options it runs what is promised: 1,000
# idle sessions for 5 minutes, 40 active ones for 5, four times overload for 2.
set -euo pipefail
cd "$(dirname "$0")/../.."
program=${1:?idle, active or overload}
shift

cmake --preset release >/dev/null
cmake --build --preset release --target "load_$program" >&2
"build/release/bin/load_$program" "$@"
