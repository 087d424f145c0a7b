#!/usr/bin/env bash
# The thesis's chapter 6 on this machine: four object classes with the bounding box, 120 genomes x 5 placements x 100
# generations = 60,000 grasps a run, everything journalled; then each champion on 200 novel placements.
#   bench/chapter6.sh BIN OUT_DIR [SEEDS]
# Writes OUT_DIR/chapter6.csv and prints its medians as a Markdown table. Needs jq.
set -euo pipefail
bin=${1:?usage: chapter6.sh BIN OUT_DIR [SEEDS]}
out=${2:?usage: chapter6.sh BIN OUT_DIR [SEEDS]}
seeds=${3:-5}
mkdir -p "$out"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

csv=$out/chapter6.csv
echo "object,seed,seconds,best_by_45,best,success,lift_success,n" >"$csv"
for object in cylinder cube sphere mug; do
  for ((seed = 1; seed <= seeds; seed++)); do
    run=$scratch/$object-$seed
    "$bin/evograsp" train "$object" --seed "$seed" --out "$run" --quiet --json >"$run.json"
    seconds=$(jq -r .seconds "$run.json")
    "$bin/evograsp" history --run "$run" --csv >"$run.csv"
    by45=$(awk -F, 'NR > 1 && NR <= 46 && $2 > b { b = $2 } END { printf "%.3f", b }' "$run.csv")
    best=$(awk -F, 'NR > 1 && $2 > b { b = $2 } END { printf "%.3f", b }' "$run.csv")
    "$bin/evograsp" test "$run" --placements 200 --box --seed 1 --json >"$run.test.json"
    success=$(jq -r '.objects[0].success' "$run.test.json")
    lift=$(jq -r '.objects[0].lift_success' "$run.test.json")
    printf '%s,%d,%.1f,%s,%s,%s,%s,200\n' "$object" "$seed" "$seconds" "$by45" "$best" "$success" "$lift" | tee -a "$csv" >&2
  done
done

median() { sort -n | awk '{ v[NR] = $1 } END { print NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'; }
column() { awk -F, -v o="$1" -v c="$2" '$1 == o { print $c }' "$csv" | median; }
echo "| object | seconds | best fitness by generation 45 | success | lowest success | lifted |"
echo "| --- | --- | --- | --- | --- | --- |"
for object in cylinder cube sphere mug; do
  lowest=$(awk -F, -v o="$object" '$1 == o { print $6 }' "$csv" | sort -n | head -n 1)
  echo "| $object | $(column "$object" 3) | $(column "$object" 4) | $(column "$object" 6) | $lowest | $(column "$object" 7) |"
done
