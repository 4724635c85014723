#!/usr/bin/env bash
# Three replicas of cagefitd behind nginx, on one PostgreSQL, all of this machine: compares their throughput with that of one, then
# kills replicas under 30 streams, 100 times, and checks that no frame is lost or doubled and that the next answer comes from another
# replica within 5 s. Options go to the program, e.g. deploy/scale/check.sh --kills 10.
set -euo pipefail
cd "$(dirname "$0")/../.."

deploy/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target soak_scale cagefitd >&2
build/release/bin/soak_scale "$@"
