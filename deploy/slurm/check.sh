#!/usr/bin/env bash
# Runs cagefit.sbatch on a real Slurm of three nodes, all of this machine: each node has process ids of its own, so that it can lose
# its power. One does in the middle of a take, another task is stopped by scancel, another by its time limit. In the end every take
# must be complete, with the bits of a run without Slurm. Needs root; installs Slurm, and leaves nothing running.
#   deploy/slurm/check.sh        CAGEFIT: the program, default: it is built
set -euo pipefail
[ -z "${CAGEFIT:-}" ] || CAGEFIT=$(realpath "$CAGEFIT")
cd "$(dirname "$0")/../.."

[ "$(id -u)" -eq 0 ] || { echo "check: needs root" >&2; exit 1; }
if ! type -P slurmctld slurmd sbatch munged >/dev/null; then
  echo "check: installing Slurm" >&2
  export DEBIAN_FRONTEND=noninteractive
  apt-get update -qq
  apt-get install -y -qq --no-install-recommends slurmctld slurmd slurm-client munge >/dev/null
fi
if [ -z "${CAGEFIT:-}" ]; then
  deploy/setup.sh
  cmake --preset release >/dev/null
  cmake --build --preset release --target cagefit >&2
fi
options=(--vertices 300)
frames=20

folder=$(mktemp -d)
chmod 755 "$folder"
export SLURM_CONF=$folder/slurm.conf
declare -A daemons  # name: process id
broken=0

clean_up() {
  local code=$?
  trap '' INT TERM
  if [ "$code" -ne 0 ] && [ -n "${daemons[slurmctld]:-}" ]; then
    { sinfo -R; squeue -o '%i %T %r %N'; tail -n 40 "$folder"/[0-9]*.log "$folder/slurmctld.log"; } >&2 || true
  fi
  for daemon in "${!daemons[@]}"; do
    kill -KILL "${daemons[$daemon]}" 2>/dev/null || true
    wait "${daemons[$daemon]}" 2>/dev/null || true
  done
  within 10 rm -rf "$folder" 2>/dev/null  # what dies may still write for a moment
}
trap clean_up EXIT
trap 'exit 1' INT TERM
cp "${CAGEFIT:-build/release/bin/cagefit}" "$folder/cagefit"  # that in build may be built anew meanwhile
export CAGEFIT=$folder/cagefit CAGEFIT_THREADS=1

# fact TEXT COMMAND...: a line for what is so when COMMAND succeeds.
fact() {
  local text=$1
  shift
  if "$@"; then echo "ok      $text"; else echo "BROKEN  $text"; broken=1; fi
}

# Polls COMMAND... for SECONDS at most.
within() {
  local end=$((SECONDS + $1))
  shift
  until "$@"; do
    [ "$SECONDS" -lt "$end" ] || return 1
    sleep 0.1
  done
}

# --- the farm

write_configuration() {
  local ports
  mapfile -t ports < <(python3 -c '
import socket
sockets = [socket.socket() for _ in range(4)]
for s in sockets: s.bind(("127.0.0.1", 0))
for s in sockets: print(s.getsockname()[1])')
  mkdir "$folder/munge" "$folder/state" "$folder/n1" "$folder/n2" "$folder/n3"
  head -c 128 /dev/urandom >"$folder/munge/key"
  chmod 600 "$folder/munge/key"
  # cred_expire: a job that is queued again waits so many seconds before it starts.
  cat >"$SLURM_CONF" <<CONF
ClusterName=check
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket,cred_expire=5
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
MailProg=/bin/true
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
SlurmdTimeout=12
KillWait=10
MinJobAge=3600
NodeName=n1 NodeHostname=n1 NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=1 RealMemory=8192
NodeName=n2 NodeHostname=n2 NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=1 RealMemory=8192
NodeName=n3 NodeHostname=n3 NodeAddr=127.0.0.1 Port=${ports[3]} CPUs=1 RealMemory=8192
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP PriorityTier=1
PartitionName=urgent Nodes=ALL MaxTime=INFINITE State=UP PriorityTier=2
CONF
}

start() {  # NAME COMMAND...
  local name=$1
  shift
  "$@" >>"$folder/$name.log" 2>&1 &
  daemons[$name]=$!
}

# With --kill-child everything on the node dies with the process that is started here.
start_node() { start "$1" unshare --pid --fork --kill-child --mount-proc --uts bash -c "hostname $1; exec slurmd -D -N $1"; }

lose_power() {
  kill -KILL "${daemons[$1]}"
  wait "${daemons[$1]}" 2>/dev/null || true
}

start_farm() {
  local munge=$folder/munge
  start munged munged --foreground --key-file="$munge/key" --socket="$munge/socket" --pid-file="$munge/pid" \
    --log-file="$munge/log" --seed-file="$munge/seed"
  within 20 test -S "$munge/socket"
  start slurmctld slurmctld -D
  for node in n1 n2 n3; do start_node "$node"; done
}

are_idle() { [ "$(sinfo -h -n "$1" -o '%T %D' 2>/dev/null)" = "idle $2" ]; }  # NODES COUNT
is_up() { sinfo -h -n "$1" -o %T 2>/dev/null | grep -qx 'idle\|allocated\|mixed'; }
is_down() { sinfo -h -n "$1" -o %T 2>/dev/null | grep -q '^down'; }

# --- jobs

# submit OUT SBATCH-OPTION... -- ARGUMENT...: prints the job's id.
submit() {
  local out=$1 log=%j sbatch_options=()
  shift
  while [ "$1" != -- ]; do
    [ "${1#--array}" = "$1" ] || log=%A_%a
    sbatch_options+=("$1")
    shift
  done
  shift
  sbatch --parsable --cpus-per-task=1 --output="$folder/$log.log" "${sbatch_options[@]}" deploy/slurm/cagefit.sbatch "$out" "$@"
}

show() { scontrol --oneliner show job "$1" 2>/dev/null | grep -oE "(^| )$2=[^ ]*" | cut -d= -f2; }  # JOB FIELD
is() { [ "$(show "$1" "$2" | sort -u | tr '\n' ' ')" = "$3 " ]; }  # JOB FIELD VALUE
is_over() { ! show "$1" JobState | grep -qvx 'COMPLETED\|FAILED\|CANCELLED\|TIMEOUT\|NODE_FAIL'; }
was_restarted() { [ "$(show "$1" Restarts)" -ge 1 ]; }
runs_on() { [ "$(squeue -h -r -j "$1" -t RUNNING -o %N 2>/dev/null)" = "$2" ]; }

answered() { find "$1/frames" -name '*.obj' 2>/dev/null | wc -l; }  # TAKE-FOLDER
is_in_the_middle() { [ "$(answered "$1")" -ge 4 ] && [ "$(answered "$1")" -lt $((frames - 4)) ]; }

# The process ids of the program of a job: JOB, or JOB_TASK.
programs_of() {
  local variables=("SLURM_JOB_ID=$1") environment
  [ "${1%_*}" = "$1" ] || variables=("SLURM_ARRAY_JOB_ID=${1%_*}" "SLURM_ARRAY_TASK_ID=${1#*_}")
  for environment in $(grep -lzx "SLURM_CONF=$SLURM_CONF" /proc/[0-9]*/environ 2>/dev/null); do
    [ "$(readlink "${environment%environ}exe")" = "$(readlink -f "$CAGEFIT")" ] || continue
    for variable in "${variables[@]}"; do
      grep -qzx "$variable" "$environment" 2>/dev/null || continue 2
    done
    basename "${environment%/environ}"
  done
}

# Waits for the middle of a take and holds its program there, so that what comes next does not come too late.
hold() {  # JOB TAKE-FOLDER
  held=()
  within 120 says "$1" '^frame ' && within 60 is_in_the_middle "$2" || return 1
  mapfile -t held < <(programs_of "$1")
  [ ${#held[@]} -eq 1 ] && kill -STOP "${held[@]}"
}
let_go() { kill -CONT "${held[@]}" 2>/dev/null || true; }

each_frame_was_fitted_once() { ! grep -o "^frame [0-9]* of $frames" "$folder/$1.log" | sort | uniq -d | grep -q .; }  # JOB
has_the_same_bits() {  # TAKE-FOLDER
  local alone=$folder/alone/${1##*/}
  [ "$(answered "$1")" -eq $frames ] && diff -rq "$alone/frames" "$1/frames" >&2 && cmp "$alone/cage.obj" "$1/cage.obj" >&2
}
says() { grep -qs "$2" "$folder/$1.log"; }  # JOB TEXT

# --- the takes, and their fit without Slurm

names=()
for k in 0 1 2 3 4 5 6 7; do
  names+=("take_$k")
  shape=$([ $((k % 2)) -eq 0 ] && echo tube || echo blob)
  "$CAGEFIT" synth "$shape" --seed "$k" --frames $frames --points 10000 --out "$folder/takes/take_$k" >/dev/null
done
captures=("${names[@]/#/$folder/takes/}")
fact "8 takes of $frames frames are fitted without Slurm" \
  "$CAGEFIT" fit --takes "${captures[@]}" --out "$folder/alone" "${options[@]}" 2>"$folder/alone.log"

write_configuration
start_farm
fact "$(slurmctld -V | cut -d' ' -f2- | sed 's/^/Slurm /') has 3 nodes" within 30 are_idle n1,n2,n3 3
[ $broken -eq 0 ] || exit 1

# --- an array that meets with every kind of break

# Tasks 6 and 7 wait until it is their turn; 7 has the array's id also as its own.
out=$folder/out
array=$(submit "$out" --array=0-7 --hold -- "${captures[@]}" -- "${options[@]}")
for k in 0 1 2 3 4 5; do scontrol release "${array}_$k"; done

lost=''
find_a_task_on_n2() {
  for k in 0 1 2 3 4 5; do
    if runs_on "${array}_$k" n2 && is_in_the_middle "$out/take_$k"; then
      lost=$k
      return
    fi
  done
  return 1
}
within 120 find_a_task_on_n2 || { echo "BROKEN  no task is fitted on n2"; exit 1; }
lose_power n2
at=$(answered "$out/take_$lost")
fact "node n2 loses its power when task $lost has $at of $frames frames" test "$at" -lt $frames
fact "nothing of task $lost is left" test -z "$(programs_of "${array}_$lost")"
fact "Slurm sees that n2 is down" within 90 is_down n2
fact "task $lost is queued again" within 60 was_restarted "${array}_$lost"
start_node n2
fact "n2 comes back" within 60 is_up n2

scontrol release "${array}_6"
fact "task 6 is in the middle of its take" hold "${array}_6" "$out/take_6"
scancel --batch --signal=TERM "${array}_6"
fact "task 6 gets SIGTERM by scancel" within 30 says "${array}_6" "${array}_6: SIGTERM"
let_go
fact "task 6 is queued again" within 60 was_restarted "${array}_6"

scontrol release "${array}_7"
fact "task 7, which has the array's id, is in the middle of its take" hold "${array}_7" "$out/take_7"
fact "it does have that id" is "${array}_7" JobId "$array"
scontrol update "JobId=${array}_7" TimeLimit=1
fact "task 7 gets SIGTERM before its time limit" within 60 says "${array}_7" "${array}_7: SIGTERM"
let_go
fact "task 7 is queued again" within 60 was_restarted "${array}_7"
scontrol update "JobId=${array}_7" TimeLimit=60

fact "all tasks come to an end" within 300 is_over "$array"
for k in 0 1 2 3 4 5 6 7; do
  task=${array}_$k
  case $k in "$lost" | 6 | 7) restarts=1 ;; *) restarts=0 ;; esac
  fact "task $k is completed after $restarts restarts" eval 'is "$task" JobState COMPLETED && is "$task" Restarts $restarts'
  [ $restarts -eq 0 ] || fact "task $k went on with its take" says "$task" "take take_$k: goes on"
  fact "task $k fitted no frame twice" each_frame_was_fitted_once "$task"
  fact "take_$k has the bits of the run without Slurm" has_the_same_bits "$out/take_$k"
done

# --- the same once more

before=$(stat -c '%n %y' "$out"/take_*/frames/* | sha256sum)
array=$(submit "$out" --array=0-7 -- "${captures[@]}" -- "${options[@]}")
fact "the same array once more comes to an end" within 120 is_over "$array"
fact "all its tasks are completed" is "$array" JobState COMPLETED
fact "it fitted nothing" test "$before" = "$(stat -c '%n %y' "$out"/take_*/frames/* | sha256sum)"

# --- preemption

out=$folder/preempted
job=$(submit "$out" --nodelist=n1 -- "${captures[0]}" -- "${options[@]}")
fact "a job is in the middle of its take on n1" hold "$job" "$out/take_0"
urgent=$(sbatch --parsable --partition=urgent --nodelist=n1 --output=/dev/null --wrap=true)
fact "it gives way to an urgent job" within 60 was_restarted "$job"
let_go
fact "the urgent job is completed" within 60 is "$urgent" JobState COMPLETED
fact "then it is completed, after 1 restart" within 120 eval 'is "$job" JobState COMPLETED && is "$job" Restarts 1'
fact "it has the bits of the run without Slurm" has_the_same_bits "$out/take_0"

# --- what must not be started again, or not for ever

job=$(submit "$folder/wrong" -- "${captures[0]}" -- --vertces 300)
fact "a job with a wrong option comes to an end" within 60 is_over "$job"
fact "it has failed with exit code 2, without a restart" \
  eval 'is "$job" JobState FAILED && is "$job" ExitCode 2:0 && is "$job" Restarts 0'

array=$(submit "$folder/wrong" --array=1-2 -- "${captures[@]}")
fact "an array that does not begin at 0 comes to an end" within 60 is_over "$array"
fact "it has failed with exit code 2, without a restart" \
  eval 'is "$array" JobState FAILED && is "$array" ExitCode 2:0 && is "$array" Restarts 0'

job=$(CAGEFIT_RESTARTS=1 submit "$folder/away" -- "${captures[0]}" -- "${options[@]}" --server 127.0.0.1:1 --give-up 1)
fact "a job without its server is started again, and fails with exit code 3 after 1 restart" \
  within 120 eval 'is "$job" JobState FAILED && is "$job" ExitCode 3:0 && is "$job" Restarts 1'

out=$folder/later
job=$(submit "$out" -- "${captures[0]}" -- "${options[@]}")
fact "a job is in the middle of its take" hold "$job" "$out/take_0"
scancel "$job"
within 30 says "$job" "$job: SIGTERM" || true
let_go
fact "it is cancelled" within 60 is "$job" JobState CANCELLED
fact "its last words are that it was stopped" within 30 says "$job" "$job: was stopped; left to Slurm"
cancelled=$job

job=$(CAGEFIT_RESTARTS=0 submit "$out" -- "${captures[0]}" -- "${options[@]}")
fact "a job that may not be started again goes on with the take" hold "$job" "$out/take_0"
scancel --batch --signal=TERM "$job"
within 30 says "$job" "$job: SIGTERM" || true
let_go
fact "it is stopped and fails with exit code 4, without a restart" \
  within 60 eval 'is "$job" JobState FAILED && is "$job" ExitCode 4:0 && is "$job" Restarts 0'

job=$(submit "$out" -- "${captures[0]}" -- "${options[@]}")
fact "the next job completes the take" within 60 is "$job" JobState COMPLETED
fact "it has the bits of the run without Slurm" has_the_same_bits "$out/take_0"
fact "the cancelled one has stayed so" eval 'is "$cancelled" JobState CANCELLED && is "$cancelled" Restarts 0'

exit $broken
