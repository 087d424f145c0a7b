#!/usr/bin/env bash
# No answer is better than a wrong one: a champion acts with the hand it was trained with, a pose is told only when a
# robot could be sent there, and what could not be written is no success.
source "$(dirname "$0")/lib.sh"

# refused CODE WORDS COMMAND...: ends with CODE, says WORDS, prints nothing.
refused() {
  expect "$1" "${@:3}"
  grep -q -e "$2" err || fail "'${*:3}' does not say '$2': $(cat err)"
  [ ! -s out ] || fail "'${*:3}' printed an answer: $(head -n 3 out)"
}

# ---- a hand of its own ----
mkdir here there
cp configs/hands/parallel_jaw.* here
mv here/parallel_jaw.txtpb here/jaw.txtpb
expect 0 "$evograsp" train quick --out run --slots 1 --quiet --set grasp.hand=here/jaw.txtpb --set neat.population=10 \
  --set run.generations=1 --set champion.candidates=1 --set champion.validation_trials=2
expect 0 "$evograsp" render --object cylinder --seed 4 --depth --out depth.png
cat >camera.json <<'END'
{"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 10000}
END
read -r u v < <("$evograsp" sim --object cylinder --seed 4 --json | tr -d ' \n' |
  sed 's/.*"click":\[\([^,]*\),\([^]]*\)\].*/\1 \2\n/' | awk '{ print int(640 * $1), int(480 * $2) }')
look=(--depth "$folder/depth.png" --camera "$folder/camera.json" --click "$u,$v" --json)

expect 0 "$evograsp" infer run "${look[@]}"
cp out true.json
cp run/champion.pb there/champion.pb
cd there || exit 1
refused 4 --hand "$evograsp" infer champion.pb "${look[@]}"
cp ../here/* .
expect 0 "$evograsp" infer champion.pb "${look[@]}"
cmp out ../true.json || fail "the same hand, found by name, gives another answer"
expect 0 "$evograsp" sim --champion champion.pb --seed 2
expect 0 "$evograsp" test champion.pb --placements 2 --no-lift --threads 1
# Another hand by the same name.
sed -i 's/tool_point { z: 0.055 }/tool_point { z: 0.12 }/' jaw.txtpb
refused 3 fingerprint "$evograsp" infer champion.pb "${look[@]}"
refused 3 fingerprint "$evograsp" sim --champion champion.pb --seed 2
refused 3 fingerprint "$evograsp" test champion.pb --placements 2 --no-lift --threads 1
refused 3 fingerprint "$evograsp" render --champion champion.pb --seed 2 --samples 1 --size 64x48 --out x.png
expect 0 "$evograsp" infer champion.pb "${look[@]}" --hand jaw.txtpb
expect 0 "$evograsp" sim --champion champion.pb --seed 2 --hand jaw.txtpb
expect 0 "$evograsp" test champion.pb --placements 2 --no-lift --threads 1 --hand ../here/jaw.txtpb
# A run.db that cannot be read is no run.db that is not there.
for damage in empty garbage cut pipe; do
  rm -f run.db
  case $damage in
    empty) : >run.db ;;
    garbage) head -c 20000 /dev/zero | tr '\0' x >run.db ;;
    cut) head -c 9000 ../run/run.db >run.db ;;
    pipe) mkfifo run.db ;;
  esac
  refused 3 run.db timeout 10 "$evograsp" infer champion.pb "${look[@]}"
  refused 3 run.db timeout 10 "$evograsp" sim --champion champion.pb --seed 2
  refused 3 run.db timeout 10 "$evograsp" test champion.pb --placements 2 --no-lift --threads 1
  expect 3 timeout 10 "$evograsp" status --run .
done
rm run.db
cd .. || exit 1

# ---- poses that no robot should get ----
camera() {
  echo "$1" >camera.json
  refused 3 "$2" "$evograsp" infer run "${look[@]}"
}
camera '{"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_meter": 10000}' units_per_metre
camera '{"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "depth_scale": 10000}' depth_scale
camera '{"fx": 525, "fx": 52, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 10000}' 'once each'
camera '{"fx": 525, "fy": 525, "cx": 1e308, "cy": 239.5, "units_per_metre": 10000}' 'no camera'
camera '{"fx": 1e-3, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 10000}' 'no camera'
camera '{"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 1000000}' 'behind the camera'
camera "$(printf '[%.0s' $(seq 1 100000))" 'JSON object'
echo '{"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 200, "sensor": "x"}' >camera.json
expect 0 "$evograsp" infer run "${look[@]}"
grep -q 'in training the camera saw' err || fail "no warning that the surface is far away: $(cat err)"
grep -q 'sensor' err || fail "no word that a key means nothing: $(cat err)"

# ---- a full disk behind standard output ----
full() {
  "$@" >/dev/full 2>err
  code=$?
  [ $code -eq 5 ] || fail "'$*' >/dev/full ended with $code, not 5: $(cat err)"
}
full "$evograsp" champion --run run --format pb
full "$evograsp" champion --run run --format json
full "$evograsp" validate --show quick
full "$evograsp" completions bash
full "$evograsp" help train
full "$evograsp" status --run run
full "$evograsp" events --run run --json
full "$evograsp" sim --champion run --json --depth
full "$evograsp" test run --placements 2 --no-lift --threads 1 --json
finish
