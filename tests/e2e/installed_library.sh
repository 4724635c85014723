#!/usr/bin/env bash
# installed_library.sh SOURCE BUILD: installs the build into a folder of its own, builds client/example against it with
# find_package(cagefit), and streams to the installed server.
set -euo pipefail
source=$1 build=$2
folder=$(mktemp -d)
server=
trap 'if [[ -n $server ]]; then kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; fi; rm -rf "$folder"' EXIT

cmake --install "$build" --prefix "$folder/prefix" >/dev/null
for file in bin/cagefit bin/cagefitd share/man/man1/cagefit-fit.1 share/man/man8/cagefitd.8 \
  share/bash-completion/completions/cagefit share/cagefit/cagefit/v1/fitting.proto; do
  [[ -f $folder/prefix/$file ]] || { echo "$file was not installed"; exit 1; }
done
# The sources must not be needed: they are copied away from the tree.
cp -r "$source/client/example" "$folder/example"
cmake -S "$folder/example" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$folder/prefix" >/dev/null
cmake --build "$folder/build" >"$folder/build.log" || { cat "$folder/build.log"; exit 1; }

"$folder/prefix/bin/cagefitd" --listen 127.0.0.1:0 --store memory >"$folder/address" 2>"$folder/log" &
server=$!
for _ in $(seq 100); do
  address=$(sed -n 's/^listening on //p' "$folder/address")
  [[ -z $address ]] || break
  sleep 0.1
done
"$folder/build/stream_clouds" "$address" | tee "$folder/out"
grep -c '200 control vertices, RMS 0\.0' "$folder/out" | grep -qx 5
