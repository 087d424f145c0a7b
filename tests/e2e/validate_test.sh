#!/usr/bin/env bash
# validate refuses with a reason and exit code 1, accepts with 0, and never dies.
source "$(dirname "$0")/lib.sh"

expect 0 "$evograsp" validate quick cylinder cube sphere mug meka_h2 configs/quick.txtpb configs/hands/meka_h2.urdf
grep -q 'quick: usable config (60 genomes x 5 trials x 40 generations = 12,000 grasps)' out || fail "no summary"

cat >bad.txtpb <<'TEXT'
run { seed: 1 }
neat {
  populaton: 20
  survival: 7
}
scene { object: "cubee" }
TEXT
expect 1 "$evograsp" validate bad.txtpb
grep -q "^bad.txtpb:3:3: unknown key 'populaton' in neat: did you mean 'population'?$" err || fail "no near miss"
grep -q "^bad.txtpb:4:13: 'neat.survival' is 7, allowed is above 0 and at most 1$" err || fail "no range"

expect 0 env EVOGRASP_NEAT__HIDDEN=3 "$evograsp" validate --show quick --set neat.population=33
grep -Eq '^neat.population +33 +flag$' out || fail "flag"
grep -Eq '^neat.hidden +3 +environment$' out || fail "environment"
grep -Eq '^run.generations +40 +file$' out || fail "file"
grep -Eq '^neat.survival +0.2 +default$' out || fail "default"

# Whatever a file is, the answer is an exit code, not a signal.
head -c 5000 /dev/urandom >noise.txtpb
cp noise.txtpb noise.obj
cp noise.txtpb noise.stl
cp noise.txtpb noise.urdf
: >empty.txtpb
: >empty.ply
head -c 100 "$here/../../configs/hands/meka_h2.urdf" >cut.urdf
for file in noise.txtpb noise.obj noise.stl noise.urdf empty.txtpb empty.ply cut.urdf . /dev/null nothing.txtpb; do
  expect 1 "$evograsp" validate "$file"
  [ -s err ] || fail "$file was refused without a reason"
done

expect 1 "$evograsp" validate --json bad.txtpb quick
grep -q '"line": 3' out || fail "JSON without the line"
finish
