#!/usr/bin/env bash
# Builds and runs a soak program: tests/soak/run.sh kill_server|kill_client|proxy [options] [-- server arguments].
# Sessions are kept in a new SQLite file unless server arguments are given. Without any options it runs what is promised: 500
# kills, 50 seeds for each fault. A failure prints the command that reproduces it.
set -euo pipefail
cd "$(dirname "$0")/../.."
program=${1:?kill_server, kill_client or proxy}
shift

cmake --preset release >/dev/null
cmake --build --preset release --target "soak_$program" >&2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
[[ " $* " == *" -- "* ]] || set -- "$@" -- --store "sqlite:$folder/sessions.db"
"build/release/bin/soak_$program" "$@"
