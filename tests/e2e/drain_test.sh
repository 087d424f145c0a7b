#!/usr/bin/env bash
# Workers of a node are taken out of a run and back in, through the API; a hint says how many slots it could use.
source "$(dirname "$0")/lib.sh"

"$server" --config quick --run-dir run --listen 'tcp://127.0.0.1:*' --http 127.0.0.1:0 --rendezvous where \
  --set run.generations=100000 2>log &
pids=($!)
for name in one two; do
  "$worker" --rendezvous where --identity $name --slots 1 2>>log &
  pids+=($!)
done
trap 'kill -KILL "${pids[@]}" 2>/dev/null; wait "${pids[@]}" 2>/dev/null; rm -rf "$folder"' EXIT
for ((i = 0; i < 100; i++)); do [ -s where ] && break; sleep 0.1; done
EVOGRASP_SERVER=$(sed -n 's/^http = //p' where)
export EVOGRASP_SERVER
of() { "$evograsp" workers --json | jq -r ".workers[] | select(.identity == \"$1\") | .$2"; }
# comes_to WORD COMMAND...: within 10 s
comes_to() {
  local wanted=$1 i
  shift
  for ((i = 0; i < 100; i++)); do
    [ "$("$@" 2>/dev/null)" = "$wanted" ] && return 0
    sleep 0.1
  done
  fail "'$*' is '$("$@")', not '$wanted': $(tail -n 3 log)"
}
comes_to active of one state
comes_to active of two state

expect 0 "$evograsp" workers drain one
grep -q 'one: 1 worker gets no more work' out || fail "drain says: $(cat out)"
comes_to draining of one state
comes_to 0 of one busy
tasks=$(of one tasks)
others=$(of two tasks)
sleep 0.5
[ "$(of one tasks)" = "$tasks" ] || fail "a drained worker still gets work"
[ "$(of two tasks)" -gt "$others" ] || fail "the other worker stands still"

# One that comes back under the name of a drained one waits as well.
kill -KILL "${pids[1]}"
wait "${pids[1]}" 2>/dev/null
"$worker" --rendezvous where --identity one --slots 1 2>>log &
pids[1]=$!
comes_to draining of one state
expect 0 "$evograsp" workers undrain one --json
comes_to active of one state
more() { [ "$(of one tasks)" -gt 0 ] && echo yes; }
comes_to yes more

expect 0 "$evograsp" workers drain "$(hostname)" --json
[ "$(jq .workers out)" = 2 ] || fail "draining the host means $(cat out)"
comes_to draining of two state
expect 0 "$evograsp" workers undrain "$(hostname)"
expect 4 "$evograsp" workers drain nobody
grep -q "no worker is called 'nobody'" err || fail "no reason: $(cat err)"
expect 2 "$evograsp" workers drain one --run run
expect 0 "$evograsp" workers
grep -q '^two ' out || fail "workers alone lists them no more"

hint() { curl -sf "$EVOGRASP_SERVER/metrics" | sed -n 's/^evograsp_slots_wanted \([1-9]\).*/yes/p'; }
comes_to yes hint
expect 0 "$evograsp" status --json
[ "$(jq .workers.slots_wanted out)" -ge 1 ] || fail "status has no hint: $(cat out)"
finish
