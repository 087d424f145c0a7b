#!/usr/bin/env bash
# Keys are made for their owner alone, never replaced unasked, and open the door they are made for.
source "$(dirname "$0")/lib.sh"

expect 0 "$evograsp" keygen master.key
[ "$(stat -c %a master.key)" = 600 ] || fail "the key file has mode $(stat -c %a master.key)"
[ "$(tr -d '\n' <out | wc -c)" -eq 40 ] || fail "standard output is no public key: $(cat out)"
grep -q secret out && fail "the secret was printed"
before=$(cat master.key)

expect 3 "$evograsp" keygen master.key
grep -q -e --force err || fail "no word how to replace a key: $(cat err)"
[ "$(cat master.key)" = "$before" ] || fail "a key was replaced unasked"
expect 0 "$evograsp" keygen master.key --force --json
grep -q '"public_key"' out || fail "no JSON: $(cat out)"
[ "$(cat master.key)" != "$before" ] || fail "--force replaced nothing"
[ "$(stat -c %a master.key)" = 600 ] || fail "the new key file has mode $(stat -c %a master.key)"
[ -e master.key.new ] && fail "a temporary file was left"

expect 0 "$evograsp" keygen worker.key --server master.key --allow workers.pub
grep -qF "$(cat out)" workers.pub || fail "the public key is not in the list"
grep -qF "server-key = $(sed -n 's/^public-key = //p' master.key)" worker.key || fail "the master's key is not in the worker's file"
expect 4 "$evograsp" keygen other.key --server nothing-there.key
[ -e other.key ] && fail "a bad server key left a file"
expect 5 "$evograsp" keygen nowhere/x.key
expect 2 "$evograsp" keygen

# A list that ends in the middle of a line, as editors leave it, gets the new key on a line of its own.
printf '%s old' "$(sed -n 's/^public-key = //p' worker.key)" >cut.pub
expect 0 "$evograsp" keygen next.key --allow cut.pub
[ "$(awk '{ print $1 }' cut.pub | grep -cxF "$(cat out)")" -eq 1 ] || fail "the new key begins no line: $(cat cut.pub)"
# What cannot be allowed, written or replaced leaves no key behind.
mkdir folder.key list.pub
expect 5 "$evograsp" keygen lost.key --allow list.pub
[ -e lost.key ] && fail "a key that nobody allows was left"
expect 5 "$evograsp" keygen lost.key --allow /dev/full
[ -e lost.key ] && fail "a key that nobody allows was left"
expect 3 "$evograsp" keygen folder.key --force
[ -e folder.key.new ] && fail "a secret was left beside the folder"
(
  ulimit -f 0
  trap '' XFSZ
  "$evograsp" keygen full.key >/dev/null 2>&1
) && fail "a key was made where nothing can be written"
[ -e full.key ] && fail "an empty key file stands in the way: $(ls -l full.key)"
expect 0 "$evograsp" keygen full.key

# A master and a worker with these keys find each other; a step client with the worker's, too.
"$server" --config quick --run-dir run --listen 'tcp://127.0.0.1:*' --http '' --set neat.population=10 \
  --set run.generations=100000 --set net.curve_secret_key_file=master.key --set net.curve_allow_file=workers.pub \
  >server.out 2>server.err &
master=$!
endpoint=$(wait_for_endpoint server.err)
"$worker" --connect "$endpoint" --slots 1 --curve-key-file worker.key >/dev/null 2>worker.err &
other=$!
for ((i = 0; i < 100; i++)); do
  "$evograsp" sim --connect "$endpoint" --curve-key-file worker.key --seed 1 >out 2>err && break
  sleep 0.1
done
grep -q 'scene of seed 1' out || fail "no trial through the encrypted door: $(cat err)"
expect 6 "$evograsp" sim --connect "$endpoint" --seed 1
kill -KILL $master $other
wait $master $other 2>/dev/null
finish
