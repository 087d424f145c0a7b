#!/usr/bin/env bash
# Runs every study that comes with the program and publishes them (bench/publish.sh). Seed 1 of all of them first, then
# seed 2, ...: whenever it is stopped, what has been published has the same seeds everywhere, and the same command goes on.
#   bench/studies.sh BIN WORK_DIR OUT_DIR MESH_DIR SEEDS [option of evograsp experiment...]
set -euo pipefail
usage="usage: studies.sh BIN WORK_DIR OUT_DIR MESH_DIR SEEDS [option of evograsp experiment...]"
bin=${1:?$usage} work=${2:?$usage} out=${3:?$usage} meshes=${4:?$usage} seeds=${5:?$usage}
shift 5
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$work" "$out"

studies=(speedup generality meshes bounding-box fitness-combinations lift one-for-all hyperneat training-effort racing)

# same FROM TO: a run that another study has made already (the same settings and seed give the same bytes).
same() {
  if [ -e "$1/champion.pb" ] && [ ! -e "$2" ]; then
    mkdir -p "$(dirname "$2")"
    cp -r "$1" "$2"
  fi
}
for ((seed = 1; seed <= seeds; seed++)); do
  for study in "${studies[@]}"; do
    [ -e "$work/$study/seeds-$seed" ] && continue
    options=(--out "$work/$study" --seeds "$seed" "$@")
    runs=$work/$study/runs
    for class in cylinder cube sphere mug; do
      case $study in
        lift | one-for-all) same "$work/generality/runs/$class-true-$seed" "$runs/$class-$seed" ;;
        hyperneat)
          same "$work/bounding-box/runs/$class-true-$seed" "$runs/$class-neat-true-$seed"
          same "$work/bounding-box/runs/$class-false-$seed" "$runs/$class-neat-false-$seed"
          ;;
      esac
    done
    [ "$study" = one-for-all ] && same "$work/meshes/runs/$seed" "$runs/all-$seed"
    [ "$study" = meshes ] && options+=(--objects-from "$meshes")
    "$bin/evograsp" experiment "$study" "${options[@]}" >&2
    "$here/publish.sh" "$work/$study" "$out/$study"
    touch "$work/$study/seeds-$seed"
    echo "$study: seeds 1 to $seed in $out/$study"
  done
done

# Rows of {object, box, success, lift_success, n}, medians over the seeds: what other programs read.
cp "$out/generality/generality.json" "$out/generality.json"
