#!/usr/bin/env bash
# Checks deploy/k8s without a cluster or a network: renders each overlay, holds it against Kubernetes' own types and our
# rules, and tries settings, metrics, alerts, nginx and the Job with the programs in build/release/bin ($CAGEFIT_BIN).
# Needs Debian's kubernetes-client, prometheus, nginx-light, python3-yaml and python3-protobuf. Exits 1 on any failure.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)

for need in kubectl:kubernetes-client promtool:prometheus nginx:nginx-light; do
  command -v "${need%:*}" >/dev/null || { echo "check: ${need%:*} is missing, of Debian's package ${need#*:}" >&2; exit 1; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Debian's own python3: it has the modules.
CAGEFIT_BIN=${CAGEFIT_BIN:-$root/build/release/bin} PYTHONDONTWRITEBYTECODE=1 \
  /usr/bin/python3 "$here/check/main.py" "$here" "$folder"
