#!/usr/bin/env bash
# A network that loses one packet in twenty, in each direction: a namespace whose loopback really drops them. In it, the
# tests of late links, of killed workers and of killed masters, all over links of 50 ms each way: the work is done, and the
# champions' bytes stay the same.
source "$(dirname "$0")/lib.sh"
[ "$(id -u)" -eq 0 ] || cannot "needs root, for network namespaces"
for program in ip nft; do command -v $program >/dev/null || cannot "needs $program: deploy/setup.sh --test"; done
space=evgl$$
clean_up() {
  ip netns del "$space" 2>/dev/null
  rm -rf "$folder"
}
trap clean_up EXIT
ip netns add "$space" 2>/dev/null || cannot "may not make network namespaces"
ip -n "$space" link set lo up
inside() { nsenter --net="/run/netns/$space" "$@"; }
inside nft -f - <<'NFT' || cannot "nft cannot drop at random here"
table inet loss {
  counter dropped { }
  chain in { type filter hook input priority 0; meta l4proto tcp numgen random mod 100 < 5 counter name dropped drop; }
}
NFT

late='Network.LateLinksAreKeptBusyAndLoseNobody:Network.LargeNetworksOverASlowLinkLoseNobody'
late+=':Network.AMasterThatIsBackIsFoundAgain'
export EVOGRASP_LOSSY=1
inside "$bin/server_fault_test" --gtest_filter="$late" >log 2>&1 || fail "under loss: $(tail -n 40 log)"
inside "$bin/server_determinism_test" --gtest_filter='RealProcesses.*' >>log 2>&1 || fail "under loss: $(tail -n 40 log)"
ran=$(grep -c '^\[       OK \]' log)
[ "$ran" -ge 6 ] || fail "only $ran tests ran: $(tail -n 5 log)"
grep -E ' took | was done' log
dropped=$(inside nft list counter inet loss dropped | grep -oE 'packets [0-9]+' | grep -oE '[0-9]+')
[ "${dropped:-0}" -gt 50 ] || fail "the network lost ${dropped:-no} packets"
echo "$ran tests passed while the network lost $dropped packets"
finish
