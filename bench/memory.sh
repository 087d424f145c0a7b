#!/usr/bin/env bash
# Whether a master grows with time: its memory, descriptors and threads as generations go by and workers come and go.
#   bench/memory.sh BIN [GENERATIONS] [CONFIG]
# Starts a server and, one after the other, workers that are killed without warning after five seconds. Prints a line at
# a tenth, a half and the end of the run.
set -euo pipefail
bin=$(cd "${1:?usage: memory.sh BIN [GENERATIONS] [CONFIG]}" && pwd)
generations=${2:-1000}
config=${3:-quick}
folder=$(mktemp -d)
pids=()
trap 'kill -KILL "${pids[@]}" 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$folder"' EXIT

"$bin/evograsp-server" --config "$config" --run-dir "$folder/run" --listen 'tcp://127.0.0.1:*' --http '' \
  --set "run.generations=$generations" --set champion.candidates=4 --stay 2>"$folder/log" >/dev/null &
server=$!
pids+=("$server")
endpoint=''
for ((i = 0; i < 200; i++)); do
  endpoint=$(grep -o 'tcp://[0-9.:]*' "$folder/log" | head -n 1) && [ -n "$endpoint" ] && break
  sleep 0.1
done
[ -n "$endpoint" ] || { cat "$folder/log" >&2; exit 1; }

(
  while :; do
    timeout --signal=KILL 5 "$bin/evograsp-worker" --connect "$endpoint" --slots 2 || true
  done
) >/dev/null 2>&1 &
pids+=("$!")

reached() { grep -o ' generation [0-9]*: best' "$folder/log" | tail -n 1 | grep -o '[0-9]*' || echo 0; }
printf '%10s %10s %12s %8s\n' generation 'RSS, kB' descriptors threads
for wanted in $((generations / 10)) $((generations / 2)) $((generations - 1)); do
  while [ "$(reached)" -lt "$wanted" ]; do
    kill -0 "$server" 2>/dev/null || { tail -n 20 "$folder/log" >&2; exit 1; }
    sleep 0.1
  done
  printf '%10s %10s %12s %8s\n' "$(reached)" "$(awk '/^VmRSS/ { print $2 }' "/proc/$server/status")" \
    "$(ls "/proc/$server/fd" | wc -l)" "$(ls "/proc/$server/task" | wc -l)"
done
