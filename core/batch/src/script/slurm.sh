#!/bin/bash
# Runs @SHARDS@ shards as a Slurm job array:   sbatch THIS_FILE
# A shard that was killed, or ran out of time, goes on where it was when it is submitted again:   sbatch --array=I THIS_FILE
# When all have ended:   @PROGRAM@ batch collect @OUT@ --output results.csv
#SBATCH --job-name=@NAME@
#SBATCH --array=1-@SHARDS@
#SBATCH --cpus-per-task=@JOBS@
#SBATCH --time=01:00:00
#SBATCH --output=@NAME@-%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
# The program is told 60 s before its time is up, ends the edits under way and keeps the rest.
#SBATCH --signal=B:TERM@60
set -euo pipefail
exec @PROGRAM@@OPTIONS@ batch @SWEEP@ --out @OUT@ --shard "$SLURM_ARRAY_TASK_ID/@SHARDS@" --jobs "${SLURM_CPUS_PER_TASK:-@JOBS@}" --resume
