#!/usr/bin/env bash
# What strangers, and a server killed at its very beginning, find at the doors of the real program.
source "$(dirname "$0")/lib.sh"

token=0123456789abcdefABCDEF
echo "$token" >token
pids=()
trap 'kill -KILL "${pids[@]}" 2>/dev/null; wait "${pids[@]}" 2>/dev/null; rm -rf "$folder"' EXIT

# Killed before its first commit, a server leaves an empty run.db: --continue begins anew.
mkdir run
: >run/run.db
"$server" --config quick --run-dir run --continue --listen 'tcp://127.0.0.1:*' --http 127.0.0.1:0 --rendezvous where \
  --set net.http_token_file=token 2>log &
pids+=($!)
for ((i = 0; i < 100; i++)); do [ -s where ] && break; sleep 0.1; done
http=$(sed -n 's/^http = //p' where)
[ -n "$http" ] || { fail "--continue with an empty run.db: $(cat log)"; finish; }

# status WANTED CURL-ARGS PATH
status() {
  local wanted=$1 got
  shift
  got=$(curl -s -o body -w '%{http_code}' "${@:1:$#-1}" "$http${!#}")
  [ "$got" = "$wanted" ] || fail "${*}: $got, not $wanted: $(head -c 300 body)"
}
status 200 /api/v1/run
status 401 -X POST /api/v1/pause
status 401 -X POST -H 'Authorization: Bearer 0123456789abcdefABCDEX' /api/v1/pause
status 202 -X POST -H "Authorization: Bearer $token" /api/v1/pause
status 416 -H 'Range: bytes=0-,0-,0-' /api/v1/events
status 415 -X POST -H "Authorization: Bearer $token" -H 'Content-Encoding: br' --data-binary 'xx' /api/v1/pause
status 200 /api/v1/run

# Killed later, it goes on.
kill -KILL "${pids[0]}"
wait "${pids[0]}" 2>/dev/null
rm -f where
"$server" --config quick --run-dir run --continue --listen 'tcp://127.0.0.1:*' --http 127.0.0.1:0 --rendezvous where 2>log &
pids+=($!)
for ((i = 0; i < 100; i++)); do [ -s where ] && break; sleep 0.1; done
http=$(sed -n 's/^http = //p' where)
status 200 /api/v1/run
kill -TERM "${pids[1]}"
wait "${pids[1]}"
code=$?
[ $code -eq 130 ] || fail "an interrupted run ends with $code, not 130"

expect 2 "$server" --config quick --run-dir other --listen '' --rendezvous where
grep -q 'wants an address' err || fail "--listen '' says: $(cat err)"
finish
