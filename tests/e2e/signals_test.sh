#!/usr/bin/env bash
# Ctrl-C, SIGTERM and SIGHUP at awkward moments: the program ends soon with exit code 130, leaves no half-written file,
# and what had begun can be gone on with.
source "$(dirname "$0")/lib.sh"

running=
trap 'kill -KILL $running 2>/dev/null; rm -rf "$folder"' EXIT
tiny=(--slots 1 --seed 3 --set neat.population=20 --set run.generations=3 --set champion.candidates=2
  --set champion.validation_trials=5)

# begin COMMAND...: in the background, where a script's shell would have it ignore Ctrl-C.
begin() {
  env --default-signal=INT "$@" >out 2>err &
  running=$!
}

# soon COMMAND...: until it is true, for 30 s at most.
soon() {
  local i
  for ((i = 0; i < 1500; i++)); do
    "$@" && return
    kill -0 $running 2>/dev/null || break
    sleep 0.02
  done
  return 1
}

# ends WHAT: what runs ends within 5 s, with 130 and no word of a crash.
ends() {
  local i code
  for ((i = 0; i < 250; i++)); do
    kill -0 $running 2>/dev/null || break
    sleep 0.02
  done
  kill -KILL $running 2>/dev/null && fail "$1: not ended after 5 s"
  wait $running
  code=$?
  [ $code -eq 130 ] || fail "$1: ended with $code, not 130: $(cat err)"
  grep -Ei 'terminate|what\(\)|assert|bug' err && fail "$1: a traceback"
  [ -z "$(find . -name '*.part' -o -name '*.tmp')" ] || fail "$1: left $(find . -name '*.part' -o -name '*.tmp')"
}

# A mesh is decomposed in a process of its own.
helps() { pgrep -P $running >child; }
for signal in INT TERM HUP; do
  for program in "$evograsp train mesh --out loaded" "$server --config mesh --run-dir loaded"; do
    begin env EVOGRASP_CACHE="$folder/cache" $program
    soon helps || fail "$program: was not seen to decompose: $(cat err)"
    kill -$signal $running
    ends "SIG$signal while $program loads"
    sleep 0.1
    grep -sq '^State:[[:space:]]*[RSDTt]' "/proc/$(head -n 1 child)/status" && fail "SIG$signal while $program loads: its child lives on"
    [ ! -e loaded ] || fail "SIG$signal while $program loads: a folder was left"
    [ -z "$(find cache -type f 2>/dev/null)" ] || break 2 # loaded before the signal came: what follows would not load
  done
done

# Killed while it makes its run.db: the folder is as good as new.
mkdir half
: >half/run.db
expect 0 "$evograsp" train quick --out half "${tiny[@]}" --quiet

# While the pictures are drawn at the end: the run is whole, and --resume draws what is missing.
expect 0 "$evograsp" train quick --out whole "${tiny[@]}" --quiet
begin "$evograsp" train quick --out drawn "${tiny[@]}" --quiet
ended() { [ -e drawn/champion.pb ] && [ ! -e drawn/run.db-wal ]; }
soon ended || fail "no champion: $(cat err)"
kill -TERM $running
ends "SIGTERM while pictures are drawn"
[ ! -e drawn/report.html ] || fail "SIGTERM came when all had been drawn"
expect 0 "$evograsp" train --resume drawn --quiet
for file in champion.pb fitness.png grasp.png; do
  cmp whole/$file drawn/$file || fail "$file is another one after an interrupted drawing"
done
[ -s drawn/report.html ] || fail "no report after an interrupted drawing"

# A second Ctrl-C insists; what was committed stays.
begin "$evograsp" train quick --out twice --slots 1 --seed 3 --set run.generations=2000
soon grep -q '^generation' err || fail "no generation: $(cat err)"
kill -INT $running
kill -INT $running
sleep 0.2
kill -INT $running 2>/dev/null
ends "Ctrl-C twice"
expect 0 "$evograsp" status --run twice

# Who is started by nohup does not hear SIGHUP.
begin env --ignore-signal=HUP "$evograsp" train quick --out nohup "${tiny[@]}" --set run.generations=30
soon grep -q '^generation' err || fail "no generation: $(cat err)"
kill -HUP $running
wait $running
code=$?
[ $code -eq 0 ] || fail "SIGHUP under nohup: ended with $code: $(cat err)"
finish
