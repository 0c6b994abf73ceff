#!/bin/bash
# Renders one image with eight tasks of a Slurm job array; each traces some blocks of the samples. Not yet tested on a
# cluster.
#
#   sbatch docs/cluster/slurm.sh scenes/teapot.glb teapot
#
# When all tasks have ended:
#
#   raystep merge teapot/part-* -o teapot.png
#
# A task that is started again continues with the blocks that are missing: sbatch --array=3 docs/cluster/slurm.sh …
#SBATCH --job-name=raystep
#SBATCH --array=1-8
#SBATCH --gres=gpu:1
#SBATCH --time=01:00:00
#SBATCH --output=%x-%A-%a.log
set -eu

N=8 # as in --array: while a single task is repeated, Slurm's own count is 1
scene=$1
out=$2

mkdir -p "$out"
raystep render "$scene" --spp 256 --size 1920x1080 --shard "$SLURM_ARRAY_TASK_ID/$N" -o "$out/part-$SLURM_ARRAY_TASK_ID"
