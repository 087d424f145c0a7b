#!/usr/bin/env bash
# A run from a config to a tested champion; stopped and resumed it gives the same bytes.
source "$(dirname "$0")/lib.sh"

small=(--set neat.population=30 --set run.generations=25 --set champion.candidates=4 --set champion.validation_trials=10)
expect 0 "$evograsp" train quick --out whole --slots 2 --seed 3 "${small[@]}" --json
for file in run.db champion.pb fitness.png report.html; do [ -s whole/$file ] || fail "no $file"; done
[ -z "$(find whole -name 'run.db-*')" ] || fail "beside run.db stays $(find whole -name 'run.db-*')"
grep -q '"state": "finished"' out || fail "JSON does not say that the run is finished"
grep -q 'generation 25/25' err || fail "no progress"

expect 0 "$evograsp" train quick --out one --slots 1 --seed 3 "${small[@]}" --quiet
cmp whole/champion.pb one/champion.pb || fail "one slot bred another champion than two"
[ ! -s err ] || fail "--quiet is not: $(head -n 3 err)"

expect 3 "$evograsp" train quick --out whole
grep -q 'train --resume whole' err || fail "no hint how to go on"

# Stopped in the middle: exit code 130, and the same champion in the end.
"$evograsp" train quick --out stopped --slots 1 --seed 3 "${small[@]}" >out 2>err &
running=$!
for ((i = 0; i < 600; i++)); do
  grep -q '^generation' err && break
  sleep 0.1
done
kill -INT $running
wait $running
code=$?
if [ $code -eq 130 ]; then
  # The signal may have come late, while the pictures of the finished run were drawn.
  grep -q 'evograsp train --resume stopped' err || "$evograsp" status --run stopped | grep -q finished ||
    fail "no word how to resume: $(cat err)"
  expect 0 "$evograsp" train --resume stopped --quiet
elif [ $code -ne 0 ]; then
  fail "interrupted training ended with $code"
fi
cmp whole/champion.pb stopped/champion.pb || fail "a resumed run bred another champion"

expect 0 "$evograsp" test whole --placements 30 --json --no-lift --threads 1
cp out one-thread
expect 0 "$evograsp" test whole/champion.pb --placements 30 --json --no-lift --threads 2
diff <(grep -v champion one-thread) <(grep -v champion out) || fail "the answer of test depends on threads"
grep -q '"n": 30' out || fail "test did not count its placements"
expect 0 "$evograsp" test whole --objects cylinder,cube --placements 10 --no-box
grep -q '^cube ' out || fail "test left an object out"

# The same object file in two folders: one experiment, one champion, which its run folder keeps usable.
mkdir here there
echo 'cuboid { x: 0.05 y: 0.04 z: 0.08 }' | tee here/box.txtpb >there/box.txtpb
tiny=(--slots 2 --quiet --set neat.population=20 --set run.generations=2 --set champion.candidates=2 --set champion.validation_trials=5)
expect 0 "$evograsp" train quick --out first "${tiny[@]}" --set scene.object=here/box.txtpb
expect 0 "$evograsp" train quick --out second "${tiny[@]}" --set "scene.object=$PWD/there/box.txtpb"
cmp first/champion.pb second/champion.pb || fail "the folder of an object file changed the champion"
rm -r here there
expect 0 "$evograsp" test first --placements 5 --no-lift
grep -q '^box.txtpb ' out || fail "test does not name the object"
expect 0 "$evograsp" sim --champion first --json
cp first/champion.pb alone.pb
expect 4 "$evograsp" test alone.pb --placements 5 --no-lift
grep -q -e '--objects' err || fail "no word how to name the object: $(cat err)"
expect 0 "$evograsp" test alone.pb --placements 5 --no-lift --objects cube

expect 2 "$evograsp" train
expect 2 "$evograsp" train quick --resume whole
expect 3 "$evograsp" train quick --out x --set neat.populaton=3
expect 3 "$evograsp" train nothing-of-that-name --out x
[ ! -e x ] || fail "a refused run left a folder"
expect 4 "$evograsp" train --resume nowhere
finish
