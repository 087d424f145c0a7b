#!/usr/bin/env bash
# Proves that bits do not depend on the machine: the digest of the same trials and lift tests from both compilers at two
# optimisation levels and on three processors, and every determinism test of a library from each build. Needs deploy/setup.sh --ci.
set -euo pipefail
cd "$(dirname "$0")/.."
trials=${1:-2000}

tests=(neat common assets sim)
build() { # PRESET TARGET...
  cmake --preset "$1" >/dev/null
  cmake --build --preset "$1" --parallel "$(nproc)" --target "${@:2}" >/dev/null
}
build release sim_digest
for preset in o2 clang; do build "$preset" sim_digest "${tests[@]/%/_determinism_test}"; done
build clang-o2 sim_digest

passed=0 failed=0 reference=
check() { # NAME COMMAND...: the command's output must equal that of the first check
  local name=$1 output
  shift
  output=$("$@") || output="exit $?"
  if [ -z "$reference" ]; then reference=$output; fi
  if [ "$output" = "$reference" ]; then
    passed=$((passed + 1)); echo "same       $name  $(echo "$output" | tail -n 1)"
  else
    failed=$((failed + 1)); echo "DIFFERENT  $name"; diff <(echo "$reference") <(echo "$output") | head -n 5
  fi
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Both at once: emulation takes longer than everything else here.
for processor in Nehalem max; do
  { qemu-x86_64 -cpu "$processor" build/release/bin/sim_digest "$trials" || echo "exit $?"; } >"$work/$processor" &
done

check "gcc -O3" build/release/bin/sim_digest "$trials"
check "gcc -O2" build/o2/bin/sim_digest "$trials"
check "clang -O3" build/clang/bin/sim_digest "$trials"
check "clang -O2" build/clang-o2/bin/sim_digest "$trials"

for preset in o2 clang; do
  for test in "${tests[@]}"; do
    if "build/$preset/bin/${test}_determinism_test" >"$work/test" 2>&1; then
      passed=$((passed + 1)); echo "same       ${test}_determinism_test built by $preset"
    else
      failed=$((failed + 1)); echo "DIFFERENT  ${test}_determinism_test built by $preset"; tail -n 20 "$work/test"
    fi
  done
done

wait
check "gcc -O3 on an emulated Nehalem" cat "$work/Nehalem"
check "gcc -O3 on every emulated extension" cat "$work/max"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
