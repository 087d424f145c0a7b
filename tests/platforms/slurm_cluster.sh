# A Slurm cluster of four nodes with two cores each on this host, on loopback, in $cluster. Sourced.
# shellcheck shell=bash disable=SC2154

cluster_possible() {
  [ "$(id -u)" -eq 0 ] || { echo "needs root, to run Slurm's daemons as the user slurm"; return 1; }
  local program
  for program in slurmctld slurmd munged setpriv; do
    command -v $program >/dev/null || { echo "needs $program: deploy/setup.sh --test"; return 1; }
  done
  mountpoint -q /sys/fs/cgroup || { echo "needs /sys/fs/cgroup mounted, for slurmd"; return 1; }
}

as_slurm() { setpriv --reuid=slurm --regid=slurm --clear-groups "$@"; }

cluster_config() { # PORT: of the controller; the nodes have those after it
  cat <<TEXT
ClusterName=test
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=$1
AuthType=auth/munge
AuthInfo=socket=$cluster/munge.sock
CredType=cred/munge
SlurmUser=slurm
SlurmdUser=slurm
StateSaveLocation=$cluster/state
SlurmdSpoolDir=$cluster/spool.%n
SlurmctldPidFile=$cluster/ctld.pid
SlurmdPidFile=$cluster/slurmd.%n.pid
SlurmctldLogFile=$cluster/ctld.log
SlurmdLogFile=$cluster/slurmd.%n.log
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=2
MpiDefault=none
SlurmdParameters=config_overrides
NodeName=n[1-4] NodeHostname=$(hostname) NodeAddr=127.0.0.1 Port=[$(($1 + 1))-$(($1 + 4))] CPUs=2 RealMemory=1000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
TEXT
}

cluster_up() {
  mkdir -p "$cluster"/{state,munge,spool.n1,spool.n2,spool.n3,spool.n4}
  cluster_config $((20000 + RANDOM % 10000)) >"$cluster/slurm.conf"
  head -c 128 /dev/urandom >"$cluster/munge.key"
  chmod 600 "$cluster/munge.key"
  chown -R slurm: "$cluster"
  export SLURM_CONF=$cluster/slurm.conf
  as_slurm munged --force --key-file="$cluster/munge.key" --socket="$cluster/munge.sock" \
    --pid-file="$cluster/munge/pid" --log-file="$cluster/munge/log" --seed-file="$cluster/munge/seed"
  as_slurm slurmctld -c
  local node
  for node in n1 n2 n3 n4; do as_slurm slurmd -N $node; done
  local i
  for ((i = 0; i < 600; i++)); do
    [ "$(sinfo --noheader --Node --states=idle 2>/dev/null | wc -l)" = 4 ] && return 0
    sleep 0.1
  done
  echo "the cluster did not come up"
  tail -n 5 "$cluster"/*.log
  return 1
}

cluster_down() {
  scancel --user=slurm 2>/dev/null
  local i file pid
  for ((i = 0; i < 50; i++)); do
    [ -n "$(squeue --noheader 2>/dev/null)" ] || break
    sleep 0.1
  done
  for file in "$cluster"/slurmd.*.pid "$cluster/ctld.pid" "$cluster/munge/pid"; do
    pid=$(cat "$file" 2>/dev/null) || continue
    kill "$pid" 2>/dev/null
    for ((i = 0; i < 50; i++)); do
      kill -0 "$pid" 2>/dev/null || break
      sleep 0.1
    done
    kill -KILL "$pid" 2>/dev/null
  done
}
