#!/usr/bin/env bash
# Slurm on this machine alone, from the distribution's packages: a sweep as a job array of eight shards, one of which is killed in the middle
# and submitted again. The table must be that of one process, byte for byte. Needs root and apt-get; takes about two minutes.
#   tests/scale/slurm.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/../.."
program=$(realpath "${1:-target/release/pliant}")
sweep=$(realpath scenes/sweeps/touch.toml)
work=$(mktemp -d)
command -v slurmctld >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends slurm-wlm munge; }

stop() {
  for file in slurmctld slurmd munged; do
    [ ! -f "$work/$file.pid" ] || kill "$(cat "$work/$file.pid")" 2>/dev/null || true
  done
  sleep 1
  rm -rf "$work"
}
trap stop EXIT

# Messages between the daemons are signed by munge, with a key and a socket of this test's own.
chmod 755 "$work"
install -d -o munge -g munge -m 755 "$work/munge"
dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chown munge:munge "$work/munge/key" && chmod 400 "$work/munge/key"
runuser -u munge -- /usr/sbin/munged --key-file "$work/munge/key" --socket "$work/munge/socket" \
  --pid-file "$work/munge/munged.pid" --log-file "$work/munge/log" --seed-file "$work/munge/seed" --force
cp "$work/munge/munged.pid" "$work/munged.pid"

mkdir "$work/state" "$work/spool" "$work/jobs"
export SLURM_CONF=$work/slurm.conf
cat > "$SLURM_CONF" <<CONF
ClusterName=single
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmctldPort=16817
SlurmdPort=16818
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=test Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
slurmctld && slurmd
for _ in $(seq 60); do sinfo --noheader | grep -q idle && break; sleep 1; done
sinfo

"$program" batch "$sweep" --quiet --out "$work/one"
cd "$work/jobs"
"$program" batch script "$sweep" --engine slurm --shards 8 --out "$work/shards" > sweep.sh
# On a machine of its own there is no limit of time to warn of.
job=$(sbatch --parsable sweep.sh)
echo "job $job: an array of 8 shards"

# Kill the process of shard 3 once it has begun.
for _ in $(seq 600); do
  pid=$(pgrep -f -- "--out $work/shards --shard 3/8" | head -1 || true)
  [ -n "$pid" ] && grep -q begin "$work/shards/shard-3-of-8.journal" 2>/dev/null && break
  sleep 0.1
done
kill -9 "$pid"
echo "shard 3 killed in the middle (process $pid)"
while [ -n "$(squeue --noheader --job "$job" 2>/dev/null)" ]; do sleep 1; done
"$program" batch status "$work/shards"
"$program" batch collect "$work/shards" --output "$work/part.csv"

echo "shard 3 submitted again"
sbatch --wait --array=3 sweep.sh
"$program" batch collect "$work/shards" --output "$work/shards.csv"
cmp "$work/one/results.csv" "$work/shards.csv"
echo "slurm: the table of 8 shards is that of one process, byte for byte"
