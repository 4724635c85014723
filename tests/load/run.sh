#!/bin/sh
# Long runs under load, by hand: tests/load/run.sh idle|active|overload [BUILD] [options of the program].
set -eu
name=$1
build=${2:-build/release}
shift; [ $# -gt 0 ] && shift
exec "$build/bin/load_$name" "$@"
