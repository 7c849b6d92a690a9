#!/bin/bash
# A sweep on a real Slurm: starts munged, slurmctld and slurmd on loopback, runs 8 shards as a job
# array, kills one and requeues it, and compares with the same sweep by two workers.
#   slurm.sh PICKBED
# Needs root and the packages slurm-wlm and munge; is skipped (exit 77) without.
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
PartitionName=loopback Nodes=ALL Default=YES MaxTime=INFINITE OverSubscribe=FORCE:4 State=UP
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

# Tasks of the array in a state, as numbers of shards.
tasks_in() { squeue --noheader --array --states="$1" --format=%K 2>/dev/null; }

start_cluster
cd "$work" || exit 1
cat >sweep.yaml <<'YAML'
scenario: cell.yaml
trials: 12
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

# A partition that is not there: refused in one line, before anything runs.
"$pickbed" sweep sweep.yaml --slurm --partition nowhere --out refused >refused.log 2>refused.err
[ $? = 1 ] || fail "an unknown partition was not refused"
grep -q "Slurm refused the job" refused.err || fail "the refusal is not told"
[ "$(grep -c "^pickbed:" refused.err)" = 1 ] || fail "the refusal is not one line"

"$pickbed" sweep sweep.yaml --slurm --out cluster --json-progress >cluster.log 2>cluster.err &
follower=$!
for _ in $(seq 600); do
  running=$(tasks_in RUNNING | head -1)
  [ -n "$running" ] && [ -s "cluster/shards/shard_${running}_of_8/results.sqlite" ] && break
  sleep 0.1
done
[ -n "$running" ] || fail "no task came to run"
job=$(cat cluster/slurm/job_id)
scancel --signal=KILL --batch "${job}_$running"
for _ in $(seq 300); do
  tasks_in RUNNING,COMPLETING | grep -qx "$running" || break
  sleep 0.1
done
echo "shard $running of job $job was killed after $(grep -c finished cluster/slurm/shard_"$running"_of_8.log) trials"
scontrol requeue "${job}_$running" || fail "cannot requeue"
scontrol update "JobId=${job}_$running" StartTime=now # Slurm would wait for two minutes
wait $follower
[ $? = 0 ] || fail "the sweep on Slurm ended with an error"
for file in trials.csv picks.csv parts.csv points.csv summary.json; do
  cmp -s "local/$file" "cluster/$file" || fail "$file differs from that of two workers"
done
[ "$(wc -l <cluster/trials.csv)" = 25 ] || fail "not 24 trials"
grep -q '"what":"trial","done":' cluster.err || fail "no progress"

# All is done: the same command finds that out, submits nothing and gives the same.
"$pickbed" sweep sweep.yaml --slurm --out cluster >again.log 2>again.err || fail "the second call"
[ "$(cat cluster/slurm/job_id)" = "$job" ] || fail "a finished sweep was submitted again"
cmp -s local/picks.csv cluster/picks.csv || fail "the second call changed the results"

# A time limit ends shards: what they finished is kept and said, and the same command goes on.
"$pickbed" sweep sweep.yaml --slurm --shards 1 --time 0:01 --trials 400 --out limited \
  >limited.log 2>limited.err
[ $? = 1 ] || fail "a sweep that met its time limit did not end with status 1"
grep -q "shard 1 of 1: TIMEOUT" limited.err || fail "the time limit is not told"
[ -s limited/trials.csv ] || fail "what was done before the time limit is not kept"
echo "passed"
