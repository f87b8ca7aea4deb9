# Runs @SHARDS@ shards with Snakemake:   snakemake --snakefile THIS_FILE --cores 8
# With an executor plugin the same file runs on a cluster. Run it again after a failure: shards go on where they were.
import os

PROGRAM, SWEEP, OUT, SHARDS = @PROGRAM@, @SWEEP@, @OUT@, @SHARDS@
OPTIONS = [@OPTIONS@]

rule all:
    input: os.path.join(OUT, "results.csv")

rule collect:
    input: expand(os.path.join(OUT, "{number}.shard"), number=range(1, SHARDS + 1))
    output: os.path.join(OUT, "results.csv")
    params: program=PROGRAM, out=OUT
    shell: "{params.program:q} batch collect {params.out:q} --output {output:q}"

rule shard:
    output: touch(os.path.join(OUT, "{number}.shard"))
    threads: @JOBS@
    retries: 3
    params: command=[PROGRAM, *OPTIONS, "batch", SWEEP, "--out", OUT]
    # Code 1 means that some edits failed, which is in their rows.
    shell: "{params.command:q} --shard {wildcards.number}/@SHARDS@ --jobs {threads} --resume --quiet || [ $? -eq 1 ]"
