#!/usr/bin/env bash
# Bakes a manifest on a Slurm cluster: an array of jobs, each a shard, and one that joins what came of them.
#
#   ./slurm.sh MANIFEST OUT [SHARDS]        # submits both, and prints their numbers
#
# Options for every shard go into VOLMAP_OPTIONS, those for sbatch into SBATCH_OPTIONS; VOLMAP names the program. OUT must be
# on a file system that all nodes share. A job that is killed, or meets its time limit, loses the asset in work: Slurm runs it
# again (--requeue), or submit the same line again.
set -euo pipefail
volmap=${VOLMAP:-volmap}

if [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
    manifest=$(realpath "${1:?give a manifest}")
    mkdir -p "${2:?give a folder for the assets}"
    out=$(realpath "$2")
    shards=${3:-4}
    # shellcheck disable=SC2086
    array=$(sbatch --parsable --job-name=volmap --array="1-$shards" --requeue --signal=B:TERM@30 \
        --output="$out/slurm-%A_%a.log" ${SBATCH_OPTIONS:-} "$(realpath "$0")" "$manifest" "$out")
    echo "shards  $array"
    # shellcheck disable=SC2086
    merge=$(sbatch --parsable --job-name=volmap-merge --dependency="afterany:$array" --output="$out/slurm-merge.log" \
        ${SBATCH_OPTIONS:-} --wrap "$(printf '%q batch --merge %q' "$volmap" "$out")")
    echo "merge   $merge"
    exit
fi

# A shard. 1: some assets failed; the summary says which, and the merge's exit code tells.
# shellcheck disable=SC2086
exec "$volmap" batch "$1" --out "$2" --shard auto --threads "${SLURM_CPUS_PER_TASK:-1}" ${VOLMAP_OPTIONS:-}
