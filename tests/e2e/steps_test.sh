#!/usr/bin/env bash
# A slot of a worker, driven step by step over the wire, answers exactly what the library answers here.
source "$(dirname "$0")/lib.sh"

"$server" --config mug --run-dir run --listen 'tcp://127.0.0.1:*' --http '' --set neat.population=10 \
  --set run.generations=100000 >server.out 2>server.err &
master=$!
endpoint=$(wait_for_endpoint server.err)

expect 6 "$evograsp" sim --connect "$endpoint" --seed 1
grep -q 'no worker' err || fail "no word that a worker is missing: $(cat err)"

"$worker" --connect "$endpoint" --slots 1 >/dev/null 2>worker.err &
other=$!
for ((i = 0; i < 100; i++)); do
  "$evograsp" sim --connect "$endpoint" --seed 1 >out 2>err && break
  sleep 0.1
done
grasped=0
for seed in 1 2 3 4 5 6; do
  for pose in "0.01 0.02 0.06 0 1 0 0.6" "0 0 0.05 0.3 0.2 0.1 -1.1"; do
    for box in --box --no-box; do
      # The target's place, so that some of the hands meet it.
      x=$("$evograsp" sim --config mug --seed $seed --json | grep -A2 '"anchor"' | sed -n 2p | tr -d ' ,')
      y=$("$evograsp" sim --config mug --seed $seed --json | grep -A3 '"anchor"' | sed -n 3p | tr -d ' ,')
      at="$x $y ${pose#* * }"
      expect 0 "$evograsp" sim --config mug --seed $seed --pose "$at" $box --json --depth
      cp out here.json
      expect 0 "$evograsp" sim --config mug --seed $seed --pose "$at" $box --json --depth --connect "$endpoint"
      cmp here.json out || fail "seed $seed, pose $at $box: another answer over the wire"
      grep -q '"outcome": "grasped"' out && grasped=$((grasped + 1))
    done
  done
done
[ $grasped -gt 0 ] || fail "no hand met the target: the comparison says little"

expect 2 "$evograsp" sim --connect "$endpoint" --object cube
grep -q -e --connect err || fail "no word why --object is refused: $(cat err)"
kill -KILL $master $other
wait $master $other 2>/dev/null
expect 6 "$evograsp" sim --connect "$endpoint" --seed 1
finish
