#!/usr/bin/env bash
# The checks that need no test run: shell scripts, room directions, words that would break reproducibility, C++.
#   deploy/lint.sh           clang-tidy over the C++ files that differ from main (or from the last commit)
#   deploy/lint.sh --all     clang-tidy over every C++ file
#   deploy/lint.sh --quick   no clang-tidy
set -uo pipefail
cd "$(dirname "$0")/.." || exit 2

scope=changed
case "${1:-}" in
  '') ;;
  --all) scope=all ;;
  --quick) scope=none ;;
  *) echo "lint.sh: unknown option '$1' (--all, --quick)" >&2; exit 2 ;;
esac

failed=0
complain() { echo "lint: $*" >&2; failed=1; }

# Rooms and what each may include beside itself: only what stands above it (docs/ARCHITECTURE.md).
declare -A may_use=(
  [common]="proto embedded"
  [neat]="proto common"
  [assets]="proto common embedded"
  [sim]="proto common assets"
  [score]="proto common"
  [server]="proto common neat assets score embedded"
  [worker]="proto common assets sim"
  [cli]="proto common neat assets sim score server worker embedded"
)

check_directions() {
  local room file line included
  for room in "${!may_use[@]}"; do
    while IFS=: read -r file line included; do
      [[ " $room ${may_use[$room]} " == *" $included "* ]] ||
        complain "$file:$line: $room/ must not include from $included/ (allowed: ${may_use[$room]})"
    done < <(grep -rnoP '^#include "\K[a-z]+(?=/)' "$room" --include='*.h' --include='*.cpp')
  done
}

# What a trial, a network or evolution touches must give the same bits everywhere: the C library picks its
# transcendental functions by processor, clocks and hash tables differ from run to run. A hash table that nobody
# iterates over says so in its line: "// lookup only".
check_reproducible() {
  local words='std::(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot|cbrt|fma)\('
  words+='|std::(unordered_(map|set)|random_device|mt19937|default_random_engine|chrono|[a-z_]+_distribution)'
  words+='|\b(s?rand|drand48|time|clock_gettime)\('
  local files
  files=$(git ls-files --cached --others --exclude-standard neat sim score 'common/network*' 'common/pose*' 'common/random*' worker/scenarios.cpp |
    grep -E '\.(h|cpp)$')
  # A comment may speak of them.
  local hits
  # shellcheck disable=SC2086
  hits=$(grep -nP "^(?!\s*//)(?:(?!//).)*($words)" $files /dev/null | grep -v '// lookup only')
  [ -z "$hits" ] || complain "not reproducible (use common/det_math.h, common/random.h, ordered containers):"$'\n'"$hits"
}

check_text() {
  local hits
  hits=$(git ls-files --cached --others --exclude-standard | grep -vE '\.(png|ply|stl|obj|bin|pb)$' |
    xargs grep -nE '\b(TODO|FIXME|XXX)\b' /dev/null | grep -v '^deploy/lint.sh:')
  [ -z "$hits" ] || complain "unfinished:"$'\n'"$hits"
}

check_shell() {
  local scripts=()
  mapfile -t scripts < <(git ls-files --cached --others --exclude-standard | while read -r file; do
    [ -f "$file" ] && head -c 64 "$file" | grep -qaE '^#!.*\b(ba)?sh\b' && echo "$file"
  done)
  if ! command -v shellcheck >/dev/null; then
    echo "lint: shellcheck is not installed (deploy/setup.sh --ci): scripts are not checked" >&2
    return
  fi
  shellcheck --external-sources --severity=warning "${scripts[@]}" || complain "shellcheck found something"
}

changed_sources() {
  local base=HEAD~1
  git rev-parse --verify -q origin/main >/dev/null && base=$(git merge-base origin/main HEAD)
  [ "$(git rev-parse "$base" 2>/dev/null)" != "$(git rev-parse HEAD)" ] || base=HEAD~1
  { git diff --name-only --diff-filter=d "$base" -- '*.cpp' 2>/dev/null; git ls-files --others --exclude-standard -- '*.cpp'; } | sort -u
}

check_tidy() {
  [ "$scope" != none ] || return 0
  if ! command -v clang-tidy >/dev/null; then
    echo "lint: clang-tidy is not installed (deploy/setup.sh --ci): C++ is not checked" >&2
    return
  fi
  [ -f build/release/compile_commands.json ] || { complain "build first (./dev build): clang-tidy needs build/release/compile_commands.json"; return; }
  local sources=()
  if [ "$scope" = all ]; then mapfile -t sources < <(git ls-files -- '*.cpp'); else mapfile -t sources < <(changed_sources); fi
  # Only what the build knows.
  local known=()
  for file in "${sources[@]}"; do grep -qF "\"file\": \"$PWD/$file\"" build/release/compile_commands.json && known+=("$file"); done
  [ ${#known[@]} -gt 0 ] || return 0
  echo "lint: clang-tidy over ${#known[@]} files" >&2
  printf '%s\0' "${known[@]}" | xargs -0 -n 1 -P "${EVOGRASP_JOBS:-$(nproc)}" clang-tidy --quiet -p build/release 2>/dev/null ||
    complain "clang-tidy found something"
}

check_directions
check_reproducible
check_text
check_shell
check_tidy
[ $failed -eq 0 ] && echo "lint: clean" >&2
exit $failed
