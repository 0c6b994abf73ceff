#!/bin/bash
# Benchmarks many scenes with a Slurm job array: each task measures some of the scenes, on a node of its own. Not yet tested
# on a cluster.
#
#   sbatch docs/cluster/slurm-bench.sh bench scenes/*.glb
#
# When all tasks have ended:
#
#   raystep merge bench/part-* -o bench-all
#
# If the nodes have different GPUs or drivers, add --mixed: each row names its device. A task that is started again replaces
# its results: sbatch --array=3 docs/cluster/slurm-bench.sh …
#SBATCH --job-name=raystep-bench
#SBATCH --array=1-4
#SBATCH --exclusive
#SBATCH --gres=gpu:1
#SBATCH --time=01:00:00
#SBATCH --output=%x-%A-%a.log
set -eu

N=4 # as in --array, and at most the number of scenes
out=$1
shift

mkdir -p "$out"
raystep bench "$@" --accelerators grid,bvh --shard "$SLURM_ARRAY_TASK_ID/$N" -o "$out/part-$SLURM_ARRAY_TASK_ID" --force
