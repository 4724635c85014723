#!/usr/bin/env bash
# Breaks manifests on purpose, one at a time in a copy, and sees that ../check.sh fails and says why: breakages.sh [PATTERN].
# Takes some minutes. Exits 1 when a breakage is not noticed.
set -euo pipefail
k8s=$(cd "$(dirname "$0")/.." && pwd)
export CAGEFIT_BIN=${CAGEFIT_BIN:-$k8s/../../build/release/bin}
pattern=${1:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0 failed=0

# broken FILE SED_EXPRESSION MESSAGE: MESSAGE is a part of what check.sh then prints.
broken() {
  [[ "$1 $2" == *"$pattern"* ]] || return 0
  rm -rf "$work/deploy"
  mkdir "$work/deploy"
  cp -r "$k8s" "$k8s/../nginx" "$work/deploy/"
  cp "$k8s/../../Dockerfile" "$work/"
  sed -i -E "$2" "$work/deploy/k8s/$1"
  if cmp -s "$k8s/$1" "$work/deploy/k8s/$1"; then
    echo "NOTHING IS BROKEN by $1: $2"
  elif "$work/deploy/k8s/check.sh" >"$work/output" 2>&1; then
    echo "NOT NOTICED: $1: $2"
  elif ! grep -qF -- "$3" "$work/output"; then
    echo "ANOTHER REASON: $1: $2"
    cat "$work/output"
  else
    echo "noticed: $1: $(grep -m1 -F -- "$3" "$work/output" | cut -c1-160)"
    passed=$((passed + 1))
    return 0
  fi
  failed=$((failed + 1))
}

single=overlays/single scaled=overlays/scaled job=overlays/job rules=monitoring/prometheus-rule.yaml

# Kubernetes' types
broken $single/stateful-set.yaml 's/replicas: 1.*/replica: 1/' 'unknown field replica'
broken $single/stateful-set.yaml 's/periodSeconds: 10/periodSecond: 10/' 'unknown field periodSecond'
broken $single/stateful-set.yaml 's/, service: cagefit.v1.Fitting/, services: cagefit.v1.Fitting/' 'unknown field services'
broken $single/stateful-set.yaml 's/enableServiceLinks: false/enableServiceLinks: "false"/' 'has the wrong type'
broken $scaled/deployment.yaml 's/ScheduleAnyway/ScheduleAnyhow/' 'ScheduleAnyhow is none of'
broken $scaled/deployment.yaml 's/apiVersion: apps.v1$/apiVersion: apps\/v2/' 'unknown kind apps/v2 Deployment'
broken $scaled/horizontal-pod-autoscaler.yaml 's/averageValue: "4"/averageValue: four/' 'has the wrong type'
broken $job/job.yaml 's/onExitCodes: \{containerName/onExitCodes: {container/' 'unknown field container'
broken monitoring/service-monitor.yaml 's/interval: 15s/every: 15s/' 'unknown field every'
broken $rules 's/^( +)for: 15m/\1during: 15m/' 'unknown field during'

# Safety
broken $single/stateful-set.yaml '/readOnlyRootFilesystem/d' 'wanted cagefitd: readOnlyRootFilesystem'
broken $scaled/nginx/deployment.yaml '/^          securityContext:/,/drop: /d' 'wanted nginx: drop ALL'
broken $job/job.yaml '/runAsNonRoot/d' 'wanted runAsNonRoot'
broken $job/job.yaml '/enableServiceLinks/d' 'wanted enableServiceLinks false'
broken $scaled/deployment.yaml '/limits: \{/d' 'requests and limits of cpu and memory'
broken $single/kustomization.yaml 's/newTag: .*/newTag: latest/' 'has no tag of a version'
broken base/network-policy.yaml 's/\[Ingress, Egress\]/[Ingress]/' 'no policy of its Egress'
broken $single/network-policy.yaml \
  '/- from:/,/cagefit-client/d; s/^        - (\{protocol.*)/    - ports: [\1]/; /^      ports:/d' \
  'opens all ports, or to everybody'

# The images
broken $job/job.yaml '/command: /d' 'Job/cagefit-fit: starts /usr/local/bin/cagefitd'
broken $job/job.yaml '/TMPDIR/d' "TMPDIR is the image's"
broken $single/stateful-set.yaml 's/runAsUser: 10001/runAsUser: 65532/' 'runs as another user'

# One thing and another
broken $single/service.yaml 's/selector: .*/selector: {app.kubernetes.io\/name: cagefit}/' 'Service/cagefit: selects no pod'
broken base/service.yaml 's/targetPort: metrics/targetPort: metric/' 'has no port metric'
broken base/service.yaml 's/name: metrics, port/name: metric, port/' '0 Services have a port metrics'
broken $scaled/pod-disruption-budget.yaml 's/matchLabels: .*nginx\}/matchLabels: {app: nginx}/' \
  'PodDisruptionBudget/cagefit-nginx: selects no pod'
broken $scaled/deployment.yaml 's/secretName: .*/secretName: postgres/' 'there is no Secret postgres'
broken $scaled/deployment.yaml 's/failureThreshold: 60/failureThreshold: 61/' 'the pods differ in more than their store'
broken $job/claims.yaml 's/name: cagefit-fitted/name: fitted/' 'there is no PersistentVolumeClaim cagefit-fitted'

# The programs
broken base/kustomization.yaml 's/CAGEFITD_LOG_FORMAT/CAGEFITD_LOGFORMAT/' 'no setting is called CAGEFITD_LOGFORMAT'
broken base/kustomization.yaml 's/DRAIN_SECONDS=20/DRAIN_SECONDS=40/' 'terminationGracePeriodSeconds above'
broken base/kustomization.yaml 's/HEALTH_LISTEN=0.0.0.0:50052/HEALTH_LISTEN=0.0.0.0:50053/' 'wanted ports as the settings have them'
broken $single/kustomization.yaml 's/sqlite:.var.lib.cagefit/sqlite:\/var\/cagefit/' 'wanted the store on a volume'
broken $scaled/kustomization.yaml 's/cagefit@postgresql/cagefit:word@postgresql/' 'it has a password'
broken $single/stateful-set.yaml 's/grpc: \{port: 50052\}/grpc: {port: 50052, service: cagefit.v1.Fitting}/' \
  'without a store its probes give'
broken $single/stateful-set.yaml 's/service: cagefit.v1.Fitting/service: cagefit.Fitting/' 'readinessProbe of '
broken $job/job.yaml 's/--format/--formats/' 'its command ends with 2'
broken $job/job.yaml 's/--takes, //' 'its command ends with'
broken $job/job.yaml 's/values: \[2\]/values: [3]/' 'a missing take ends with 2'
broken $scaled/nginx/cagefit.conf 's/grpc_connect_timeout 2s/grpc_connect_timeout 3s/' "nginx's cagefit.conf is not the same"
broken $scaled/nginx/run.sh '/-s reload/d' 'a server that has come is called'
broken $scaled/nginx/run.sh 's/\[ -s now.conf \] && //' 'an empty answer of DNS is taken for no servers'
broken $scaled/nginx/nginx.conf 's/include cagefit.conf;/include cagefit.conf/' 'nginx: it does not listen'

# Prometheus
broken $rules 's/cagefit_queue_depth\{/cagefit_queue_length{/' 'no server has a metric cagefit_queue_length'
broken $rules 's/pool="fits"/pool="fit"/' 'cagefit_queue_depth has no pool fit'
broken $rules 's/expr: cagefit_ready == 0/expr: cagefit_ready = 0/' 'promtool check rules'
broken $rules 's/> 16/> 60/' 'promtool test rules'
broken $rules \
  's/^( +)or sum by/\1and sum by/' \
  'promtool test rules'
broken $rules 's/0.85 \* 8 \*/0.85 * 16 */' 'is not the 16Gi of CagefitMemoryNearLimit'
broken monitoring/cagefit.json 's/cagefit_frame_stage_seconds_bucket/cagefit_frame_seconds_bucket/' \
  'no server has a metric cagefit_frame_seconds_bucket'
broken $scaled/horizontal-pod-autoscaler.yaml 's/pool: fits/pool: fit/' 'cagefit_queue_depth has no pool fit'

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
