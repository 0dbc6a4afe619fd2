#!/usr/bin/env bash
# Bakes a manifest on a Slurm cluster: an array of jobs, each a shard, and one that joins what came of them.
#
#   ./slurm.sh MANIFEST OUT [SHARDS]        # submits both, and prints their numbers
#
# Options for every shard go into VOLMAP_OPTIONS (--cache, --timeout; threads and memory are those of the job), those for
# sbatch into SBATCH_OPTIONS ("--cpus-per-task=8 --mem=16G --time=1:00:00"); VOLMAP names the program. OUT must be on a file
# system that all nodes share. A shard that is killed, meets its time limit or loses its node goes back into the queue, up to
# three times, and loses the asset in work only. The exit code of the job that joins says whether all assets are good.
set -euo pipefail
volmap=${VOLMAP:-volmap}

submit() {
    local manifest out array merge
    manifest=$(realpath -e "${1:?give a manifest}")
    mkdir -p "${2:?give a folder for the assets}"
    out=$(realpath "$2")
    # What earlier runs tell must not stand for a shard of this one.
    find "$out" -maxdepth 1 \( -name 'summary.*-of-*.json' -o -name 'summary.*-of-*.html' -o -name 'junit.*-of-*.xml' \) -delete
    # shellcheck disable=SC2086
    array=$(sbatch --parsable --job-name=volmap --array="1-${3:-4}" --requeue --signal=B:TERM@30 --open-mode=append \
        --output="$out/slurm-%A_%a.log" ${SBATCH_OPTIONS:-} "$(realpath "$0")" --shard "$manifest" "$out")
    echo "shards  $array"
    # shellcheck disable=SC2086
    merge=$(sbatch --parsable --job-name=volmap-merge --dependency="afterany:${array%%;*}" \
        --output="$out/slurm-%j-merge.log" ${SBATCH_OPTIONS:-} "$(realpath "$0")" --merge "$out")
    echo "merge   $merge"
}

shard() {
    local memory child code=0 limit=()
    memory=$((${SLURM_MEM_PER_NODE:-$((${SLURM_MEM_PER_CPU:-0} * SLURM_CPUS_ON_NODE))} * 7 / 8))
    [ "$memory" -eq 0 ] || limit=(--max-memory "${memory}MiB")
    # In the background, for the signal that Slurm sends to this script before the time is up.
    # shellcheck disable=SC2086
    "$volmap" batch "$1" --out "$2" --shard auto --threads "$SLURM_CPUS_ON_NODE" "${limit[@]}" ${VOLMAP_OPTIONS:-} &
    child=$!
    trap 'kill -TERM "$child" 2>/dev/null || :' TERM
    wait "$child" || code=$?
    while kill -0 "$child" 2>/dev/null; do code=0 && wait "$child" || code=$?; done
    # From 128: stopped or killed. Jobs that a user cancelled stay so.
    if [ "$code" -ge 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ] && [ "$(state)" = RUNNING ]; then
        echo "shard $SLURM_ARRAY_TASK_ID ended with code $code and is tried again"
        scontrol requeue "$SLURM_JOB_ID"
    fi
    exit "$code"
}

state() { squeue --noheader --jobs="$SLURM_JOB_ID" --format=%T; }

case "${1:-}" in
--shard) shard "$2" "$3" ;;
--merge) exec "$volmap" batch --merge "$2" ;;
*) submit "$@" ;;
esac
