#!/bin/bash
# A study as an array job: sbatch studies/array_job.sh studies/mold/curves/skin_thickness.toml /shared/skin_thickness
# Every task takes a third of the cases; after the last one, collect with
#   porousmold study STUDY.toml --out DIR --collect
# Without SLURM, task by task: LAUNCH="mpirun -n 2" SLURM_ARRAY_TASK_ID=1 SLURM_ARRAY_TASK_COUNT=3 bash studies/array_job.sh ...
#SBATCH --job-name=porousmold
#SBATCH --array=1-3
#SBATCH --ntasks=2
#SBATCH --time=01:00:00
set -euo pipefail
export OMP_NUM_THREADS=1
${LAUNCH:-srun} porousmold study "$1" --out "$2" --part "${SLURM_ARRAY_TASK_ID}/${SLURM_ARRAY_TASK_COUNT}" --quiet
