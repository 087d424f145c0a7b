#!/usr/bin/env bash
# Four hosts: network namespaces with addresses of their own on one bridge, a server and three workers, CURVE on. A link
# is cut without a word and restored under load, another goes down and up, a stranger knocks. The champion has the
# bytes of a run on one machine.
source "$(dirname "$0")/lib.sh"
[ "$(id -u)" -eq 0 ] || cannot "needs root, for network namespaces"
for program in ip nft; do command -v $program >/dev/null || cannot "needs $program: deploy/setup.sh --test"; done
lan=evg$$
hosts=(master one two three)
pids=()
clean_up() {
  [ ${#pids[@]} -eq 0 ] || kill -KILL "${pids[@]}" 2>/dev/null
  wait 2>/dev/null
  for host in "${hosts[@]}" lan; do ip netns del "$lan-$host" 2>/dev/null; done
  rm -rf "$folder"
}
trap clean_up EXIT
ip netns add "$lan-lan" 2>/dev/null || cannot "may not make network namespaces"

# The switch is in a namespace as well: nothing of the machine's own network is touched.
ip -n "$lan-lan" link add name lan type bridge
ip -n "$lan-lan" link set dev lan up
at=1
for host in "${hosts[@]}"; do
  ip netns add "$lan-$host"
  ip -n "$lan-lan" link add name "to-$host" type veth peer name eth0 netns "$lan-$host"
  ip -n "$lan-lan" link set dev "to-$host" master lan up
  ip -n "$lan-$host" link set lo up
  ip -n "$lan-$host" address add 10.77.0.$at/24 dev eth0
  ip -n "$lan-$host" link set eth0 up
  at=$((at + 1))
done
on() { # HOST COMMAND...
  local host=$1
  shift
  nsenter --net="/run/netns/$lan-$host" "$@"
}
start() { # HOST LOG COMMAND...: sets started
  nsenter --net="/run/netns/$lan-$1" "${@:3}" 2>"$2" &
  started=$!
  pids+=("$started")
}

# Outlasts the cuts and their ends, on any machine: these workers take their time over each task. Quick ones end the run.
slow=sleep:0.05
small=(--seed 5 --set run.generations=400 --set champion.candidates=4 --set champion.validation_trials=10)
"$evograsp" train quick --out local --slots 2 --quiet "${small[@]}" || fail "the run on one machine failed"

expect 0 "$evograsp" keygen server.key
for host in one two three; do expect 0 "$evograsp" keygen $host.key --server server.key --allow workers.allow; done
expect 0 "$evograsp" keygen stranger.key --server server.key
EVOGRASP_TOKEN=0123456789abcdef start master log.master "$server" --config quick --run-dir run --stay "${small[@]}" \
  --listen 'tcp://10.77.0.1:5555' --http 10.77.0.1:8080 --set net.curve_secret_key_file=server.key --set net.curve_allow_file=workers.allow
for host in one two three; do
  EVOGRASP_FAULT=$slow start $host log.$host "$bin/evograsp-worker-faulty" --connect tcp://10.77.0.1:5555 --identity $host \
    --slots 1 --curve-key-file $host.key
done
start one log.stranger "$worker" --connect tcp://10.77.0.1:5555 --identity stranger --slots 1 --curve-key-file stranger.key
start two log.plain "$worker" --connect tcp://10.77.0.1:5555 --identity plain --slots 1

ask() { on master curl -sf "http://10.77.0.1:8080/api/v1/$1"; }
here_are() { [ "$(ask workers | jq -r '[.workers[] | select(.state == "active") | .identity] | sort | join(" ")')" = "$1" ]; }
within 90 here_are 'one three two' || { fail "three workers do not join: $(ask workers) $(tail -n 3 log.*)"; finish; }


now() { date +%s.%N; }
# timed LIMIT WHAT COMMAND...: until it succeeds, which is to take at most LIMIT seconds; said, and checked.
timed() {
  local limit=$1 what=$2 begun took
  shift 2
  begun=$(now)
  within 90 "$@" || { fail "not in 90 s: $what: $(ask workers) $(tail -n 3 log.*)"; finish; }
  took=$(awk -v from="$begun" -v to="$(now)" 'BEGIN { printf "%.2f", to - from }')
  echo "$what after $took s"
  awk -v took="$took" -v limit="$limit" 'BEGIN { exit !(took <= limit) }' || fail "$what after $took s: more than $limit"
}
still_running() { [ "$(ask run | jq -r .state)" = running ] || fail "the run was over before $1: raise run.generations"; }
# How much a worker has done.
tasks_of() { ask workers | jq --arg who "$1" '[.workers[] | select(.identity == $who and .state == "active") | .tasks] | add // 0'; }
works_again() { [ "$(tasks_of "$1")" -gt 0 ]; }
cut() {
  on two nft -f - <<'NFT'
table inet cut {
  chain in { type filter hook input priority 0; policy drop; }
  chain out { type filter hook output priority 0; policy drop; }
}
NFT
}

# A cut that nobody hears of: everything into and out of the host is dropped. Short, and long enough for the kernel's
# own retries to have become rare.
for seconds in 5 12; do
  cut
  timed 3 "a silent cut of $seconds s was noticed" here_are 'one three'
  sleep "$seconds"
  still_running "the link was restored"
  on two nft delete table inet cut
  timed 2 "a worker was back, the link cut for $seconds s being restored," here_are 'one three two'
  timed 2 'and worked' works_again two
  still_running "the worker was back"
done
# A cable pulled, and put back: at once, when no session need end, and after five seconds.
for seconds in 0.3 5; do
  ip -n "$lan-lan" link set dev to-three down
  sleep "$seconds"
  still_running "the cable was put back"
  ip -n "$lan-lan" link set dev to-three up
  timed 2 "a worker was there, its cable pulled for $seconds s being put back," here_are 'one three two'
  timed 2 'and worked' works_again three
  still_running "the worker was back"
done

# What is left is done by quick ones: they come before the slow ones go, so that somebody is always there.
for host in "${hosts[@]:1}"; do
  start $host log.quick.$host "$worker" --connect tcp://10.77.0.1:5555 --identity quick-$host --slots 1 --curve-key-file $host.key
done
within 90 here_are 'one quick-one quick-three quick-two three two' || fail "quick workers do not join: $(ask workers)"
for host in "${hosts[@]:1}"; do
  on master curl -sf -X POST -H 'Authorization: Bearer 0123456789abcdef' -d "{\"node\": \"$host\"}" \
    http://10.77.0.1:8080/api/v1/workers/drain >/dev/null || fail "$host is not drained"
done
finished() { [ "$(ask run | jq -r .state)" = finished ]; }
within 150 finished || fail "the run does not end: $(ask run)"
cmp run/champion.pb local/champion.pb || fail "four hosts bred another champion"
grep -q 'key .* is not on the allow-list' log.master || fail "the server does not speak of the stranger"
for name in stranger plain; do
  if grep -q 'welcome' log.$name; then fail "$name was let in"; fi
done
finish
