#!/bin/bash
# Runs @SHARDS@ shards with GNU parallel, as many at a time as the machine has room for:   bash THIS_FILE
# On several machines that share the folder:   bash THIS_FILE --sshlogin host1,host2 --workdir .
# A shard that fails is tried three times; it goes on where it was. Run the script again after an interruption.
set -uo pipefail
at_a_time=$(( $(nproc) / @JOBS@ ))
seq @SHARDS@ | parallel --jobs $(( at_a_time > 0 ? at_a_time : 1 )) --retries 3 --line-buffer "$@" \
  @PROGRAM@@OPTIONS@ batch @SWEEP@ --out @OUT@ --shard {}/@SHARDS@ --jobs @JOBS@ --resume
@PROGRAM@ batch collect @OUT@ --output @OUT@/results.csv
