#!/usr/bin/env bash
# Training with HyperNEAT: the substrate follows the camera, and a champion is a network like any other.
source "$(dirname "$0")/lib.sh"

small=(--quiet --set neat.population=20 --set run.generations=4 --set champion.candidates=3 --set champion.validation_trials=5)

expect 0 "$evograsp" train hyperneat --out two --slots 2 "${small[@]}"
expect 0 "$evograsp" train hyperneat --out one --slots 1 "${small[@]}"
cmp two/champion.pb one/champion.pb || fail "one slot bred another champion than two"
expect 0 "$evograsp" test two --placements 5 --no-lift
grep -q '^cube ' out || fail "the champion was not tested"

# A finer image: nothing but the camera is said. Any config can be turned to HyperNEAT.
expect 0 "$evograsp" train quick --out fine --slots 2 "${small[@]}" --set 'neat.hyperneat={}' \
  --set camera.columns=40 --set camera.rows=30
expect 0 "$evograsp" test fine --placements 5 --no-lift

# A substrate of another size than the image: where it stands, and what to do.
cat >wrong.txtpb <<'CONFIG'
scene { object: "cube" }
neat { hyperneat { input_columns: 30 } }
CONFIG
expect 3 "$evograsp" train wrong.txtpb --out wrong
grep -q "wrong.txtpb:2:35: 'neat.hyperneat.input_columns': is 30, but camera.columns is 20" err ||
  fail "the mistake is not named: $(cat err)"

finish
