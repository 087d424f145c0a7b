#!/usr/bin/env bash
# A master does not grow with its generations, nor with the workers that come and go. The long form, and its figures:
# docs/RESULTS.md.
source "$(dirname "$0")/lib.sh"

expect 0 "$here/../../bench/memory.sh" "$bin" 80
read -r _ first_kb first_fds first_threads < <(sed -n 2p out)
read -r _ last_kb last_fds last_threads < <(sed -n 4p out)
[ "${last_kb:-0}" -gt 0 ] || fail "no figures: $(cat out)"
# Networks grow a little as they evolve; a page a generation would be a leak.
[ $((last_kb - first_kb)) -lt 4096 ] || fail "memory grew: $(cat out)"
[ $((last_fds - first_fds)) -le 8 ] || fail "descriptors grew: $(cat out)"
[ "$last_threads" -eq "$first_threads" ] || fail "threads grew: $(cat out)"
finish
