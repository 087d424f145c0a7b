#!/usr/bin/env bash
# A study from its file to its page: interrupted and resumed it gives the same tables, whose numbers are those of run.db.
source "$(dirname "$0")/lib.sh"

cat >tiny.txtpb <<'TEXT'
title: "A tiny study"
config: "quick"
set: "neat.population=16" set: "run.generations=4" set: "champion.candidates=2" set: "champion.validation_trials=4"
seeds: 2
axis { name: "class" value { name: "cube" set: "scene.object=cube" } value { name: "cylinder" test_object: "cylinder" test_object: "cuboid" } }
axis { name: "box" value { name: "true" } value { name: "false" set: "trials.bounding_box=false" set: "camera.feature=CENTROID" } }
test { placements: 6 lift: false }
curve { terms: true every: 2 placements: 4 }
table { name: "grasps" by: "object" by: "box" column { of: "success" } column { of: "n" } }
plot { name: "curve" title: "<curve> & co" panel: "class" series: "box" y: "best" }
plot { name: "bars" kind: BARS source: TESTS x: "object" series: "box" y: "success" percent: true }
TEXT

expect 0 "$evograsp" experiment tiny.txtpb --plan
[ "$(wc -l <out)" -eq 8 ] || fail "the plan has $(wc -l <out) runs, not 8"

expect 0 "$evograsp" experiment tiny.txtpb --out whole --json
jq -e '.runs == 8 and .planned == 8 and (.tables.grasps | length) == 6' out >/dev/null || fail "JSON: $(cat out)"
for file in README.md report.html {runs,tests,generations,grasps}.{csv,json} {curve,bars}.{svg,png}; do
  [ -s "whole/$file" ] || fail "no $file"
done
if command -v xmllint >/dev/null; then xmllint --noout whole/*.svg || fail "an SVG is not well formed"; fi
[ "$(head -n 1 whole/tests.csv)" = "class,box,seed,object,n,successes,success,lifts,lift_success,unseen,extent_m,refused" ] ||
  fail "columns of tests.csv: $(head -n 1 whole/tests.csv)"
[ "$(wc -l <whole/tests.csv)" -eq 13 ] || fail "tests.csv has $(wc -l <whole/tests.csv) lines"
[ "$(wc -l <whole/generations.csv)" -eq 33 ] || fail "generations.csv has $(wc -l <whole/generations.csv) lines"
jq -e 'all(.[]; (.box | type) == "boolean" and .n == 6)' whole/grasps.json >/dev/null || fail "types in grasps.json"

# What the tables say is what run.db holds; f1 to f4, simulated again, add up to the stored fitness.
db=whole/runs/cylinder-true-2/run.db
jq -r '.[] | select(.class == "cylinder" and .box and .seed == 2) | [.generation, .best, .mean, .trials] | @csv' \
  whole/generations.json >ours
sqlite3 -csv -readonly $db 'SELECT generation, best, mean, trials FROM generations ORDER BY generation' >theirs
paste -d, ours theirs | awk -F, '{ for (i = 1; i <= 4; i++) if (($i - $(i + 4)) ^ 2 > 1e-24) exit 1 }' ||
  fail "generations.json and run.db disagree: $(diff ours theirs)"
jq -e 'all(.[]; (.f1 + .f2 + .f3 + .f4 - .best) | fabs < 1e-12)' whole/generations.json >/dev/null ||
  fail "the terms of a generation's best do not add up to its fitness"
"$evograsp" test whole/runs/cylinder-true-2 --objects cuboid --placements 6 --no-lift --json >test.json
[ "$(jq '.objects[0].successes' test.json)" = "$(jq '.[] | select(.class == "cylinder" and .box and .seed == 2 and .object == "cuboid").successes' whole/tests.json)" ] ||
  fail "the study's test and evograsp test disagree"

# Again: nothing is repeated, nothing changes.
find whole/runs -name run.db -newer whole/tests.json | grep -q . && fail "a run.db is newer than the tables"
cp whole/tests.csv before.csv
expect 0 "$evograsp" experiment tiny.txtpb --out whole --quiet
cmp before.csv whole/tests.csv || fail "the second call changed the answer"
[ ! -s err ] || fail "--quiet is not: $(head -n 3 err)"

# Each is a run like any other.
expect 0 "$evograsp" train --resume whole/runs/cube-true-1 --quiet

# Stopped after the first run or later; the same command goes on with it.
"$evograsp" experiment tiny.txtpb --out stopped >out 2>err &
running=$!
for ((i = 0; i < 600; i++)); do
  [ -e stopped/runs/cube-true-1/measured.json ] && break
  sleep 0.05
done
kill -INT $running
wait $running
code=$?
if [ $code -eq 130 ]; then
  grep -q 'the same command goes on' err || fail "no word how to go on: $(cat err)"
  grep -q 'of 8 runs so far' stopped/README.md || fail "the page does not say that runs are missing"
elif [ $code -ne 0 ]; then
  fail "an interrupted study ended with $code"
fi
expect 0 "$evograsp" experiment tiny.txtpb --out stopped
for file in tests.csv grasps.json; do cmp whole/$file stopped/$file || fail "a resumed study has another $file"; done

# Other settings do not mix with runs that are there.
expect 3 "$evograsp" experiment tiny.txtpb --out whole --set neat.hidden=2
grep -q 'neat.hidden' err || fail "no word what differs: $(cat err)"
expect 3 "$evograsp" experiment tiny.txtpb --out x --set neat.hiden=2
[ ! -e x ] || fail "a refused study left a folder"
expect 2 "$evograsp" experiment tiny.txtpb --only klass=cube
expect 2 "$evograsp" experiment
expect 3 "$evograsp" experiment nothing-of-that-name
expect 0 "$evograsp" experiment --list
grep -q '^fitness-combinations *140' out || fail "the list: $(cat out)"
finish
