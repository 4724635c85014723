#!/bin/sh
# Runs nginx and keeps its list of servers up to date, from the addresses that the headless Service has: run.sh CONFIG_FOLDER.
#
# nginx does not do this alone: by default it looks a name up once, and with `resolve` all addresses of one name share one
# place in the consistent hash, so that a session's calls go round all servers. Sorted, the list is the same in every nginx.
set -eu
run=/tmp/nginx
mkdir -p "$run"
cp "$1/nginx.conf" "$1/cagefit.conf" "$run/"
cd "$run"

servers() {
  getent ahosts "${CAGEFIT_REPLICAS:-cagefitd}" |
    awk '$2 == "STREAM" { address = $1 ~ /:/ ? "[" $1 "]" : $1; print "server " address ":50051 max_fails=0;" }' | sort -u
}

servers >cagefit_replicas.conf || true
# None yet: who calls is told to try again.
[ -s cagefit_replicas.conf ] || echo "server 127.0.0.1:1 max_fails=0;" >cagefit_replicas.conf

# An empty answer may be DNS being away: then the last list stays. Streams go on in the old workers until they end.
set +e
while sleep 2; do
  servers >now.conf
  if [ -s now.conf ] && ! cmp -s now.conf told.conf; then
    cp now.conf cagefit_replicas.conf
    nginx -c "$run/nginx.conf" -s reload && mv now.conf told.conf
  fi
done &
exec nginx -c "$run/nginx.conf" -g 'daemon off;'
