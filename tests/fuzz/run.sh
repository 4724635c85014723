#!/usr/bin/env bash
# Fuzzes with libFuzzer, AddressSanitizer and UBSan: tests/fuzz/run.sh [--runs N] [TARGET...], by default a million executions of
# each target, in turn. New inputs stay in build/fuzz/corpus/TARGET; a crash is kept there as crash-..., and
# build/fuzz/bin/fuzz_TARGET FILE runs it again.
set -euo pipefail
cd "$(dirname "$0")/../.."

runs=1000000
if [[ ${1:-} == --runs ]]; then
  runs=$2
  shift 2
fi
cmake --preset fuzz >/dev/null
if [[ $# -gt 0 ]]; then
  cmake --build --preset fuzz --target "${@/#/fuzz_}" >&2
else
  cmake --build --preset fuzz >&2
  set -- $(cd build/fuzz/bin && ls -d fuzz_* | sed s/fuzz_//)
fi

export ASAN_OPTIONS=quarantine_size_mb=16:${ASAN_OPTIONS:-}
status=0
for target in "$@"; do
  corpus=build/fuzz/corpus/$target
  program=build/fuzz/bin/fuzz_$target
  CAGEFIT_FUZZ_SEEDS=$corpus "$program"
  log=$(mktemp)
  # A second and half a GiB are far more than any of these inputs may take.
  if "$program" -runs="$runs" -rss_limit_mb=512 -malloc_limit_mb=128 -timeout=5 -max_len=4096 -detect_leaks=1 \
    -print_final_stats=1 -artifact_prefix="$corpus/../$target-" "$corpus" >"$log" 2>&1; then
    echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") executions"
  else
    status=1
    tail -40 "$log"
    echo "$target: FAILED"
  fi
  rm -f "$log"
done
exit "$status"
