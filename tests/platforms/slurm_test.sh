#!/usr/bin/env bash
# A run on a real Slurm: a server job and an array of workers; the server runs out of time and is queued again, a worker
# too, a task is cancelled, a node is drained. The champion has the bytes of a run on one machine.
source "$(dirname "$0")/lib.sh"
source "$here/slurm_cluster.sh"
cluster=$folder/cluster
reason=$(cluster_possible) || cannot "$reason"
trap 'cluster_down; rm -rf "$folder"' EXIT

# The user of the cluster must reach programs and run.
chmod 755 "$folder"
mkdir bin shared
cp "$evograsp" "$server" "$worker" bin/
chown slurm: shared
small=(--seed 5 --set run.generations=300 --set champion.candidates=4 --set champion.validation_trials=10)
"$evograsp" train quick --out local --slots 2 --quiet "${small[@]}" || fail "the run on one machine failed"

cluster_up || { fail "no cluster"; finish; }
run=$folder/shared/run
submit=(as_slurm bin/evograsp slurm submit --workers 4 quick --out "$run" --listen 'tcp://127.0.0.1:*' "${small[@]}")
expect 0 "${submit[@]}" --dry-run
grep -q -- '--array=0-3 .*workers.sbatch' out || fail "--dry-run does not show the array"
[ ! -e "$run" ] || fail "--dry-run wrote something"
expect 3 "${submit[@]}" --set neat.populaton=3
expect 0 "${submit[@]}" --json
server_job=$(jq -r .server_job out)
array=$(jq -r .workers_job out)

log() { cat "$run/slurm/$1.log" 2>/dev/null; }
welcomes() { log "worker-$1" | grep -c 'welcome to'; }
all_work() { for i in 0 1 2 3; do [ "$(welcomes "$i")" -ge 1 ] || return 1; done; }
node_of() { squeue --noheader --jobs="$1" --states=RUNNING --format=%N; }
requeued() { [ "$(squeue --noheader --jobs="$1" --format=%r)" = BeginTime ]; }
# Slurm lets two minutes pass before a job that was queued again; the test does not.
at_once() {
  within 90 requeued "$1" || { fail "job $1 was not queued again: $(squeue)"; return; }
  as_slurm scontrol update job="$1" starttime=now
}
within 90 all_work || fail "the workers of the array did not all join: $(tail -n 3 "$run"/slurm/*.log)"
[ "$(stat -c %a "$run/slurm/worker.key")" = 600 ] || fail "others may read the workers' key"

as_slurm srun --overlap --jobid="$server_job" bin/evograsp status --run "$run" >status 2>&1
grep -q 'quick: running' status || fail "status on the server's node: $(cat status)"

# Out of time, a worker and then the server: what Slurm sends before the limit.
as_slurm scancel --signal=USR1 --batch "${array}_3"
at_once "${array}_3"
grep -q draining <<<"$(log worker-3)" || fail "a worker out of time was not drained"
as_slurm scancel --signal=USR1 --batch "$server_job"
at_once "$server_job"
back() { [ "$(log server | grep -c 'workers: tcp://127.0.0.1')" -ge 2 ]; }
within 90 back || fail "the server's job did not come back: $(log server)"
find_it_again() { [ "$(welcomes 0)" -ge 2 ]; }
within 90 find_it_again || fail "a worker did not find the server again by its rendezvous: $(log worker-0)"

# A task is cancelled: its worker hands back what it has.
as_slurm scancel "${array}_0"
gone() { [ -z "$(squeue --noheader --jobs="${array}_0" 2>/dev/null)" ]; }
within 90 gone || fail "a cancelled task stays"
grep -q draining <<<"$(log worker-0)" || fail "a cancelled worker was not drained"

# A node is drained: its task is queued again and runs elsewhere.
node=$(node_of "${array}_1")
if [ -n "$node" ]; then
  as_slurm scontrol update nodename="$node" state=drain reason=test
  as_slurm scontrol requeue "${array}_1"
  at_once "${array}_1"
  moved() { local now; now=$(node_of "${array}_1"); [ -n "$now" ] && [ "$now" != "$node" ]; }
  within 90 moved || fail "the task of a drained node does not run elsewhere: $(squeue)"
else
  fail "the run was over before a node could be drained: raise run.generations"
fi

finished() { [ -z "$(squeue --noheader 2>/dev/null)" ]; }
within 90 finished || fail "the run does not end: $(squeue) $(log server | tail -n 5)"
grep -q 'finished: ' <<<"$(log server)" || fail "the server did not finish: $(log server | tail -n 5)"
cmp local/champion.pb "$run/champion.pb" || fail "Slurm bred another champion"
grep -q 'over = the run is finished' "$run/rendezvous" || fail "the rendezvous does not say that the run is over: $(cat "$run/rendezvous")"
finish
