#!/usr/bin/env python3
"""Runs @SHARDS@ shards as tasks of Dask.

On this machine:    python3 THIS_FILE
On a cluster:       python3 THIS_FILE tcp://SCHEDULER:8786   (workers see the same folders)

A task whose worker dies runs again on another one, and its shard goes on where it was.
"""

import os
import subprocess
import sys

from dask.distributed import Client, LocalCluster, as_completed

SHARDS, JOBS = @SHARDS@, @JOBS@
COMMAND = [@PROGRAM@, @OPTIONS@"batch", @SWEEP@, "--out", @OUT@, "--jobs", str(JOBS), "--resume"]


def run_shard(number):
    """Runs one shard to its end; 1 means that some runs failed, which is in their rows."""
    code = subprocess.run([*COMMAND, "--shard", f"{number}/{SHARDS}", "--quiet"]).returncode
    if code not in (0, 1):
        raise RuntimeError(f"shard {number}/{SHARDS} ended with code {code}")
    return number


def main():
    if len(sys.argv) > 1:
        cluster, client = None, Client(sys.argv[1])
    else:
        workers = max(1, (os.cpu_count() or 1) // JOBS)
        cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
        client = Client(cluster)
    tasks = client.map(run_shard, range(1, SHARDS + 1), pure=False, retries=3)
    for done, task in enumerate(as_completed(tasks), 1):
        print(f"shard {task.result()}: {done} of {SHARDS} done", flush=True)
    client.close()
    if cluster is not None:
        cluster.close()
    return subprocess.run([@PROGRAM@, "batch", "collect", @OUT@, "--output", os.path.join(@OUT@, "results.csv")]).returncode


if __name__ == "__main__":
    sys.exit(main())
