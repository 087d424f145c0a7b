#!/usr/bin/env bash
# Runs the fuzzers of the preset `fuzz`, two at a time. Ends at the first input that breaks a target.
#   deploy/fuzz.sh [TARGET...] [--seconds N]    default: every target, 60 s each
# EVOGRASP_FUZZ_PATIENCE: seconds that one input may take (default: 30).
# What is found new is kept in build/fuzz/found/TARGET/ for the next time, broken inputs in build/fuzz/broken/.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 2

seconds=60
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds) seconds=${2:-}; shift ;;
    -*) echo "fuzz.sh: unknown option '$1' (--seconds N)" >&2; exit 2 ;;
    *) targets+=("$1") ;;
  esac
  shift
done
[[ "$seconds" =~ ^[0-9]+$ ]] || { echo "fuzz.sh: --seconds wants a number" >&2; exit 2; }
programs=build/asan/bin
if [ ${#targets[@]} -eq 0 ]; then
  for source in tests/fuzz/*_fuzz.cpp; do targets+=("$(basename "$source" _fuzz.cpp)"); done
fi

# Larger inputs find little and cost much.
declare -A most_bytes=([config]=16384 [hand]=32768 [mesh]=4096 [object]=4096 [worker]=8192)

export LSAN_OPTIONS="suppressions=$PWD/deploy/lsan.supp ${LSAN_OPTIONS:-}"

fuzz_one() {
  local target=$1 log=build/fuzz/$1.log options=() folders=() status
  [ -x "$programs/${target}_fuzz" ] || { echo "$target: there is no fuzzer of that name" >&2; return 2; }
  mkdir -p "build/fuzz/found/$target" build/fuzz/broken
  folders=("build/fuzz/found/$target" "tests/fuzz/corpus/$target")
  [ ! -d "tests/fuzz/regressions/$target" ] || folders+=("tests/fuzz/regressions/$target")
  [ ! -f "tests/fuzz/$target.dict" ] || options+=("-dict=tests/fuzz/$target.dict")
  # Beside the limits that the product keeps by itself (2 GB, and 20 s for a mesh), with room for a busy machine.
  local TIMEFORMAT='clock %R processor %U %S'
  { time "$programs/${target}_fuzz" "${options[@]}" -seed="${EVOGRASP_FUZZ_SEED:-0}" -max_total_time="$seconds" -timeout="${EVOGRASP_FUZZ_PATIENCE:-30}" -rss_limit_mb=2560 \
    -max_len="${most_bytes[$target]:-4096}" -artifact_prefix="build/fuzz/broken/$target-" -print_final_stats=1 \
    "${folders[@]}"; } >"$log" 2>&1
  status=$?
  if [ $status -eq 0 ]; then
    printf '%-12s %s\n' "$target" \
      "$(awk '/^#[0-9]+/ {line=$0} /number_of_executed_units/ {n=$2} /^clock/ {clock=$2; cpu=$4+$5}
        END {match(line, /cov: [0-9]+/); printf "%d inputs, %s, %.1f minutes, %.0f s of processor\n", n, substr(line, RSTART, RLENGTH), clock / 60, cpu}' "$log")"
    return 0
  fi
  echo "$target: BROKEN (log: $log)"
  grep -E '^(==[0-9]+==)?(ERROR|SUMMARY)|runtime error|fuzz: does not hold|Test unit written' "$log" | head -n 10 | sed 's/^/    /'
  echo "    keep the input once it is fixed: mv build/fuzz/broken/$target-... tests/fuzz/regressions/$target/NAME"
  return 1
}

failed=0
running=0
for target in "${targets[@]}"; do
  if [ $running -ge "${EVOGRASP_JOBS:-2}" ]; then
    wait -n || failed=1
    running=$((running - 1))
  fi
  fuzz_one "$target" &
  running=$((running + 1))
done
while [ $running -gt 0 ]; do
  wait -n || failed=1
  running=$((running - 1))
done
exit $failed
