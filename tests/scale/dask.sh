#!/usr/bin/env bash
# Dask's LocalCluster with two workers: a sweep as eight shards, one of which is killed in the middle and runs again by itself. The table must
# be that of one process, byte for byte. Installs Dask into a virtual environment if Python has none.
#   tests/scale/dask.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/../.."
program=$(realpath "${1:-target/release/pliant}")
sweep=$(realpath scenes/sweeps/touch.toml)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=python3
if ! python3 -c "import dask.distributed" 2>/dev/null; then
  python3 -m venv "$work/venv"
  "$work/venv/bin/pip" install --quiet "dask[distributed]"
  python=$work/venv/bin/python
fi

"$program" batch "$sweep" --quiet --out "$work/one"
"$program" batch script "$sweep" --engine dask --shards 8 --out "$work/shards" > "$work/sweep.py"
$python "$work/sweep.py" &
dask=$!

# Kill the process of shard 3 once it has begun; Dask runs its task again.
for _ in $(seq 600); do
  pid=$(pgrep -f -- "--out $work/shards .*--shard 3/8" | head -1 || true)
  [ -n "$pid" ] && grep -q begin "$work/shards/shard-3-of-8.journal" 2>/dev/null && break
  sleep 0.1
done
kill -9 "$pid"
echo "shard 3 killed in the middle (process $pid)"
wait $dask
cmp "$work/one/results.csv" "$work/shards/results.csv"
echo "dask: the table of 8 shards is that of one process, byte for byte"
