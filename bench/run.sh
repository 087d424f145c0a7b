#!/usr/bin/env bash
# Runs the benchmarks: bench/run.sh BIN_DIR [--filter REGEX] [--json FILE] [-- GOOGLE-BENCHMARK-FLAGS]
# A table on stdout; --json writes Google Benchmark's own format, one entry a benchmark under its fixed name. Look at
# the CPU column on a machine that does other things, too.
set -euo pipefail

usage() { sed -n '2,4s/^# //p' "$0" >&2; }

[ $# -ge 1 ] || { usage; exit 2; }
bin=$1
shift
filter=. json='' extra=()
while [ $# -gt 0 ]; do
  case "$1" in
    --filter) filter=${2:?--filter needs a regular expression}; shift 2 ;;
    --filter=*) filter=${1#*=}; shift ;;
    --json) json=${2:?--json needs a file}; shift 2 ;;
    --json=*) json=${1#*=}; shift ;;
    -h | --help) usage; exit 0 ;;
    --) shift; extra=("$@"); break ;;
    *) echo "bench/run.sh: unknown option '$1'" >&2; usage; exit 2 ;;
  esac
done

program=$bin/evograsp-bench
[ -x "$program" ] || { echo "bench/run.sh: $program is not there (./dev build first)" >&2; exit 4; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" --benchmark_filter="$filter" --benchmark_out="$work/out.json" --benchmark_out_format=json "${extra[@]}" >"$work/table" 2>"$work/log" ||
  { cat "$work/log" "$work/table" >&2; exit 1; }
[ -s "$work/table" ] || { echo "bench/run.sh: no benchmark matches '$filter'" >&2; exit 1; }

awk 'BEGIN { printf "%-36s %14s %14s\n", "benchmark", "time", "CPU" }
     $3 ~ /^(ns|us|ms|s)$/ && $5 ~ /^(ns|us|ms|s)$/ {
       printf "%-36s %11s %-2s %11s %-2s", $1, $2, $3, $4, $5
       for (i = 7; i <= NF; ++i) printf "  %s", $i
       printf "\n"
       cpu[$1] = $4 * ($5 == "ms" ? 1e6 : $5 == "us" ? 1e3 : $5 == "s" ? 1e9 : 1)
     }
     / ERROR / { print }
     END {
       if (cpu["epsilon/8"] > 0 && cpu["epsilon_qhull/8"] > 0)
         printf "\nepsilon: %.0f times faster than qhull with the options of GraspIt!\n", cpu["epsilon_qhull/8"] / cpu["epsilon/8"]
     }' "$work/table"

if [ -n "$json" ]; then cp "$work/out.json" "$json"; fi
