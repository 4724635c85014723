#!/usr/bin/env bash
# The Dockerfile's build: cagefit and cagefitd, tests, and a folder that holds what an image adds to its base.
#   deploy/container/build.sh WITH_TEMPLATE BASE_PACKAGES FOLDER
# WITH_TEMPLATE is ON or OFF; the others are those of collect.sh. TESTS, TEST_PROGRAMS and JOBS: see the Dockerfile.
set -euo pipefail
cd "$(dirname "$0")/../.."
with_template=$1 base_packages=$2 folder=$3
test_programs=()
[ -z "${TESTS:-}" ] || read -ra test_programs <<<"${TEST_PROGRAMS:?}"

# Hits whatever the folder and the language that filled the cache.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1 LANG=C.UTF-8
cmake --preset release -DCAGEFIT_WITH_TEMPLATE="$with_template" >/dev/null
cmake --build --preset release -j "${JOBS:-2}" --target cagefit cagefitd "${test_programs[@]}"
if [ -n "${TESTS:-}" ]; then
  ctest --preset release --no-tests=error -R "$TESTS" -E '_NOT_BUILT$'
fi
deploy/container/collect.sh "$base_packages" "$folder" build/release/bin/cagefit build/release/bin/cagefitd
