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

# refused FILE REASON: exit code 1, the file named, the reason in words.
refused() {
  expect 1 "$evograsp" validate "$1"
  grep -q "^$1: .*$2" err || fail "$1 was refused without '$2': $(cat err)"
}
cube='v 0 0 0\nv .1 0 0\nv 0 .1 0\nv .1 .1 0\nv 0 0 .1\nv .1 0 .1\nv 0 .1 .1\nv .1 .1 .1\n'
faces='f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n'
printf %b "$cube${faces}f 2 4 8 6\n" >cube.obj
expect 0 "$evograsp" validate cube.obj
ply='ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n'
ply+='element face 1\nproperty list uchar int vertex_indices\nend_header\n'
printf %b "${ply}0 0 0\n.1 0 0\n" >truncated.ply
refused truncated.ply "cut short: its header announces 3 of 'vertex', only 2 are there"
printf %b "${ply}0 0 0\n.1 0 0\n0 nan 0\n3 0 1 2\n" >infinite.ply
refused infinite.ply 'a vertex is not finite'
truncate -s 65M large.stl
refused large.stl 'larger than the 67108864 bytes allowed'
printf %b "${ply/vertex 3/vertex 2000001}" >many.ply
refused many.ply 'more than 2000000 vertices'
printf %b "${cube}f 1 2 4 3\n" >flat.obj
refused flat.obj 'it encloses no volume'
printf %b "$cube$faces" >unclosed.obj
expect 0 "$evograsp" validate unclosed.obj
grep -q 'unclosed.obj: not closed (4 open edges)' err || fail "an open mesh without a warning"

# What only the simulator refuses.
{ echo 'sphere { radius: 0.03 }'; for i in $(seq 257); do echo "resting_down { x: 0.$i z: -1 }"; done; } >restless.txtpb
refused restless.txtpb 'needs 1 to 256 resting poses'
limit='<limit lower="0" upper="0.04" effort="1" velocity="1"/>'
box='<collision><geometry><box size="0.02 0.01 0.06"/></geometry></collision>'
cat >wild.urdf <<END
<robot name="wild"><link name="p">$box</link><link name="l">$box</link><link name="r">$box</link>
<joint name="a" type="prismatic"><parent link="p"/><child link="l"/><origin xyz="0 0.05 0.03"/><axis xyz="0 -1 0"/>$limit</joint>
<joint name="b" type="prismatic"><parent link="p"/><child link="r"/><origin xyz="0 -0.05 0.03"/><axis xyz="0 1 0"/>$limit
<mimic joint="a" multiplier="1"/></joint></robot>
END
expect 0 "$evograsp" validate wild.urdf
sed 's/multiplier="1"/multiplier="1e300"/' wild.urdf >ratio.urdf
refused ratio.urdf 'hand: '
sed '1s/p">/p"><collision><origin xyz="0 0 1e300"\/><geometry><sphere radius="0.01"\/><\/geometry><\/collision>/' wild.urdf >far.urdf
refused far.urdf ''

expect 1 "$evograsp" validate --json bad.txtpb quick
grep -q '"line": 3' out || fail "JSON without the line"
finish
