#!/usr/bin/env bash
# What `./dev run` does after building: train a controller, look at it, judge it, say what to try next.
#   deploy/first-run.sh BIN [CONFIG] [TRAIN-OPTIONS]
set -euo pipefail
bin=${1:?usage: first-run.sh BIN [CONFIG] [TRAIN-OPTIONS]}
shift
config=configs/quick.txtpb
if [ $# -gt 0 ] && [[ $1 != -* ]]; then config=$1; shift; fi

name=$(basename "$config" .txtpb)
runs=${EVOGRASP_RUNS:-runs}
out=$runs/$name
for ((i = 2; ; i++)); do
  [ -e "$out/run.db" ] || break
  out=$runs/$name-$i
done

# What to try next is said below, after the test.
"$bin/evograsp" train "$config" --out "$out" "$@" | sed '/^Next:$/,$d'
echo "pictures: $out/fitness.png (how it learnt), $out/grasp.png (a grasp of the champion), $out/report.html (all)"
echo
"$bin/evograsp" test "$out/champion.pb" --placements 100
cat <<TEXT

Three things to try next:
  $bin/evograsp test $out --objects mug,sphere     does it grasp what it was not trained on?
  $bin/evograsp train mug --seed 7                 another object, the thesis's full size
  $bin/evograsp validate --show $name              every setting there is
TEXT
