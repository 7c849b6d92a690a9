#!/bin/bash
# Tests a sweep on a real Slurm cluster. Starts munged, slurmctld and slurmd on loopback and runs 8
# shards as a job array. Kills one shard halfway and requeues it. The results must be the same as in the
# same sweep with two local workers.
#   slurm.sh PICKBED
# Needs root and the packages slurm-wlm and munge. Without them it is skipped (exit status 77).
set -u
pickbed=$1
[ "$(id -u)" = 0 ] || { echo "skipped: a cluster can only be started as root"; exit 77; }
for program in munged slurmctld slurmd sbatch squeue scontrol; do
  command -v $program >/dev/null || { echo "skipped: there is no $program"; exit 77; }
done

work=$(mktemp -d "${TMPDIR:-/tmp}/pickbed_slurm_XXXXXX")
chmod 755 "$work"
daemons=()
stop_all() {
  scancel --quiet --user=root 2>/dev/null
  sleep 1
  for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null; done
  wait 2>/dev/null
  rm -rf "$work"
}
trap stop_all EXIT
fail() {
  echo "FAIL: $*" >&2
  for log in "$work"/*.log "$work"/*.err "$work"/*/slurm/*.log; do
    [ -s "$log" ] && tail -20 "$log" | sed "s|^|  $(basename "$log"): |" >&2
  done
  exit 1
}

start_cluster() {
  local host port=$((20000 + RANDOM % 10000))
  host=$(hostname -s)
  export SLURM_CONF=$work/slurm.conf
  mkdir "$work/munge" "$work/state" "$work/spool"
  head -c 1024 /dev/urandom >"$work/munge/key"
  chmod 400 "$work/munge/key"
  cat >"$SLURM_CONF" <<CONF
ClusterName=loopback
SlurmctldHost=$host(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
SlurmUser=root
SlurmdUser=root
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
KillWait=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=loopback Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  munged --force --foreground --num-threads=2 --socket="$work/munge/socket" \
    --key-file="$work/munge/key" --pid-file="$work/munge/pid" --log-file="$work/munge/log" \
    --seed-file="$work/munge/seed" >"$work/munged.log" 2>&1 &
  daemons+=($!)
  for _ in $(seq 100); do [ -S "$work/munge/socket" ] && break; sleep 0.1; done
  slurmctld -D -i >"$work/slurmctld.log" 2>&1 &
  daemons+=($!)
  slurmd -D -N "$host" >"$work/slurmd.log" 2>&1 &
  daemons+=($!)
  for _ in $(seq 300); do
    [ "$(sinfo --noheader --format=%t 2>/dev/null)" = idle ] && return
    sleep 0.1
  done
  fail "the cluster did not start"
}

# Prints the shard numbers of the array tasks in a state.
tasks_in() { squeue --noheader --array --states="$1" --format=%K 2>/dev/null; }

# wait_for SECONDS WHAT COMMAND...: waits until the command succeeds. Fails with the message WHAT.
wait_for() {
  local seconds=$1 what=$2
  shift 2
  for _ in $(seq $((10 * seconds))); do
    "$@" && return
    sleep 0.1
  done
  squeue --array >&2
  fail "after $seconds s: $what"
}

# Prints the number of trials in the store of a shard.
done_of() {
  rm -rf peek
  "$pickbed" merge "cluster/shards/shard_$1_of_8" --out peek >/dev/null 2>peek.err || { echo 0; return; }
  echo $(($(wc -l <peek/trials.csv) - 1))
}

# Stops a task that has done some but not all of its trials, and sets `victim` to its shard. The signal
# goes to the process itself, because Slurm treats a task that it stops as suspended.
stop_half_done() {
  local shard pid count
  for shard in $(tasks_in RUNNING); do
    pid=$(sed -n 's/^process \([0-9]*\) .*/\1/p' "cluster/shards/shard_${shard}_of_8/lock" 2>/dev/null)
    [ -n "$pid" ] && kill -STOP "$pid" 2>/dev/null || continue
    sleep 0.3 # its worker finishes the current trial
    count=$(done_of "$shard")
    if [ "$count" -ge 1 ] && [ "$count" -lt 6 ]; then
      victim=$shard
      victim_pid=$pid
      half_done=$count
      return 0
    fi
    kill -CONT "$pid" 2>/dev/null
  done
  return 1
}
task_is_over() { ! tasks_in RUNNING,COMPLETING | grep -qx "$victim"; }
requeued() { scontrol requeue "${job}_$victim" 2>requeue.err; }

start_cluster
cd "$work" || exit 1
cat >sweep.yaml <<'YAML'
scenario: cell.yaml
trials: 24
set: {estimator.name: oracle}
grid:
  estimator.noise_mm: [0.5, 3]
slurm: {shards: 8, partition: loopback}
YAML
cat >cell.yaml <<'YAML'
seed: 7
objects:
  - {name: rod, count: 3}
  - {name: flange, count: 2}
YAML

"$pickbed" sweep sweep.yaml --jobs 2 --out local >local.log 2>local.err || fail "the sweep of two workers"

# An unknown partition is refused in one line before anything runs.
"$pickbed" sweep sweep.yaml --slurm --partition nowhere --out refused >refused.log 2>refused.err
[ $? = 1 ] || fail "an unknown partition was not refused"
grep -q "Slurm refused the job" refused.err || fail "the refusal by Slurm is not reported"
[ "$(grep -c "^pickbed:" refused.err)" = 1 ] || fail "the refusal is not one line"

# The last task is held until the victim is back in the queue. An empty queue would end the command
# that follows the job.
"$pickbed" sweep sweep.yaml --slurm --out cluster --json-progress >cluster.log 2>cluster.err &
follower=$!
wait_for 60 "no job was submitted" test -s cluster/slurm/job_id
job=$(cat cluster/slurm/job_id)
held=8
scontrol hold "${job}_$held" || fail "cannot hold the last task"
wait_for 120 "no task was seen half done" stop_half_done
kill -KILL "$victim_pid" || fail "cannot kill the task"
wait_for 60 "the killed task $victim is not over" task_is_over
[ "$(done_of "$victim")" -ge "$half_done" ] || fail "shard $victim lost what it had done"
wait_for 60 "cannot requeue task $victim" requeued
echo "shard $victim of job $job was killed after $half_done of 6 trials and requeued"
scontrol update "JobId=${job}_$victim" StartTime=now # Slurm would wait for two minutes
scontrol release "${job}_$held" || fail "cannot release the last task"
wait $follower
status=$?
[ $status = 0 ] || fail "the sweep on Slurm ended with status $status: $(tail -1 cluster.err)"
for file in trials.csv attempts.csv instance_outcomes.csv configurations.csv summary.json; do
  cmp -s "local/$file" "cluster/$file" || fail "$file differs from the file of two workers"
done
[ "$(wc -l <cluster/trials.csv)" = 49 ] || fail "not 48 trials"
grep -q '"what":"trial","done":' cluster.err || fail "no progress"
grep -q '"done":48,"total":48,.*"executed_grasps":[1-9].*"success_ci95":' cluster.err ||
  fail "the last line of progress has no success rate"

# The sweep is finished: the same command submits nothing and gives the same results.
"$pickbed" sweep sweep.yaml --slurm --out cluster >again.log 2>again.err || fail "the second call"
[ "$(cat cluster/slurm/job_id)" = "$job" ] || fail "a finished sweep was submitted again"
cmp -s local/attempts.csv cluster/attempts.csv || fail "the second call changed the results"

# The end of a shard before its last trial is reported with Slurm's reason. Its finished trials are kept.
"$pickbed" sweep sweep.yaml --slurm --shards 1 --time 0:20:00 --trials 400 --out ended --json-progress \
  >ended.log 2>ended.err &
follower=$!
wait_for 60 "no finished trial" grep -q '"what":"trial","done":[1-9]' ended.err
job=$(cat ended/slurm/job_id)
[ "$(squeue --noheader --array --jobs="$job" --format=%l)" = 20:00 ] || fail "the time limit is not as requested"
scancel "$job"
wait $follower
[ $? = 1 ] || fail "a sweep whose shard was ended did not end with status 1"
grep -q "shard 1 of 1: CANCELLED" ended.err || fail "the end of the shard is not reported"
[ -s ended/trials.csv ] || fail "trials that finished before the end are not kept"
echo "passed"
