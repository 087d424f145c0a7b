#!/usr/bin/env bash
# A worker that is told to end while the rendezvous names no master, the run being over, ends with 0.
source "$(dirname "$0")/lib.sh"

"$server" --config quick --run-dir run --listen 'tcp://127.0.0.1:*' --http '' --rendezvous where \
  --set neat.population=20 --set run.generations=2 2>served &
serving=$!
"$worker" --rendezvous where --slots 1 2>log &
working=$!
trap 'kill -KILL $serving $working 2>/dev/null; rm -rf "$folder"' EXIT
wait $serving || fail "the run did not end well: $(cat served)"
for ((i = 0; i < 100; i++)); do grep -q 'connecting anew' log && break; sleep 0.1; done
sleep 0.3
kill -TERM $working
wait $working
code=$?
[ $code -eq 0 ] || fail "the worker ended with $code: $(cat log)"
finish
