#!/usr/bin/env bash
# The map of grasps from the command line: kept, shown, drawn, and its cells tried like any champion.
source "$(dirname "$0")/lib.sh"

small=(--quiet --slots 2 --set neat.population=30 --set run.generations=8 --set champion.candidates=2 --set champion.validation_trials=4)

expect 0 "$evograsp" train quick --out run "${small[@]}" --set 'neat.archive={ x { bins: 6 } y { of: OFFSET bins: 4 } }'
expect 0 "$evograsp" archive --run run
grep -q ' of 24 kinds of grasp found' out || fail "the map is not counted: $(head -n 1 out)"
grep -q 'approach pitch, degrees' out || fail "the axis has no name"
expect 0 "$evograsp" archive --run run --best 0 --json
cp out map.json
jq -e '.cells == 24 and .x.bins == 6 and .x.high == 90 and .y.measure == "OFFSET" and .y.high == 0.1' map.json >/dev/null ||
  fail "the axes: $(jq -c '.x, .y' map.json)"
jq -e '.elites | length > 1 and all(.[]; .x < 6 and .y < 4 and .judged >= 1)' map.json >/dev/null ||
  fail "elites: $(jq -c .elites map.json)"

# Each elite lies in the cell that its place says, and run.db says the same.
jq -e '.elites | all(.[]; ([(.x_value / 15 | floor), 5] | min) == .x and ([(.y_value / 0.025 | floor), 3] | min) == .y)' map.json \
  >/dev/null || fail "an elite is in the wrong cell"
[ "$(sqlite3 -readonly run/run.db 'SELECT count(*) FROM elites')" = "$(jq '.elites | length' map.json)" ] ||
  fail "run.db holds another map"

for file in map.png map.svg; do
  expect 0 "$evograsp" archive --run run --out $file
  [ -s $file ] || fail "no $file"
done
expect 2 "$evograsp" archive --run run --out map.bmp

cell=$(jq -r '.elites | max_by(.fitness) | "\(.x),\(.y)"' map.json)
expect 0 "$evograsp" champion --run run --cell "$cell" --out elite.pb
expect 0 "$evograsp" test elite.pb --placements 4 --no-lift
expect 0 "$evograsp" champion --run run --cell "$cell"
grep -q "the elite of cell $cell" out || fail "it does not say whose champion it is"
expect 2 "$evograsp" champion --run run --cell "8;3"
grep -q "is no cell like 8,3" err || fail "the mistake is not named: $(cat err)"
empty=$(jq -r '[range(6) as $x | range(4) as $y | [$x, $y]] - [.elites[] | [.x, .y]] | first | "\(.[0]),\(.[1])"' map.json)
expect 4 "$evograsp" champion --run run --cell "$empty"
grep -q "cell $empty of the map is empty" err || fail "the empty cell is not named: $(cat err)"

# Only watched, evolution goes its own way.
expect 0 "$evograsp" train quick --out watched "${small[@]}" --set 'neat.archive={ children: 0 again: 0 }'
expect 0 "$evograsp" train quick --out plain "${small[@]}"
cmp watched/champion.pb plain/champion.pb || fail "watching changed the champion"
expect 4 "$evograsp" archive --run plain
grep -q 'neat.archive={}' err || fail "it does not say how to get a map: $(cat err)"

# Mistakes have names.
expect 1 "$evograsp" validate quick --set neat.archive.x.low=3
grep -q "low and high are given together" err out || fail "half a range: $(cat err out)"
expect 3 "$evograsp" train quick --set neat.archive.children=0.97 --out wrong
grep -q "shares of the population" err || fail "shares: $(cat err)"

finish
