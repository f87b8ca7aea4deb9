#!/bin/bash
# Runs @SHARDS@ shards as a HyperQueue task array:   bash THIS_FILE   (hq server and workers are running)
# Run it again after a failure: shards go on where they were.
# When all have ended:   @PROGRAM@ batch collect @OUT@ --output results.csv
set -euo pipefail
shard() {
  exec @PROGRAM@@OPTIONS@ batch @SWEEP@ --out @OUT@ --shard "$HQ_TASK_ID/@SHARDS@" --jobs @JOBS@ --resume
}
export -f shard
hq submit --name @NAME@ --array 1-@SHARDS@ --cpus @JOBS@ --crash-limit 3 --cwd "$PWD" -- bash -c "$(declare -f shard); shard"
