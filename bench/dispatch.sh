#!/usr/bin/env bash
# How many evaluations one master gives out and takes in, side by side with others: bench/dispatch.sh BIN_DIR [--peers]
#   --peers   also Dask's submit(), when Debian's python3-distributed is installed
# The floor is the least that ROUTER/DEALER and protobuf can do with the same bytes, one genome a message.
# How many slots a master keeps busy: `evograsp bench dispatch`.
set -euo pipefail

[ $# -ge 1 ] || { sed -n '2,5s/^# //p' "$0" >&2; exit 2; }
bin=$1
shift
peers=false
case "${1:-}" in
  '') ;;
  --peers) peers=true ;;
  *) echo "bench/dispatch.sh: unknown option '$1'" >&2; exit 2 ;;
esac
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$bin/evograsp-bench" --benchmark_filter='^dispatch(_floor)?/20k$' --benchmark_out="$work/out.json" --benchmark_out_format=json \
  --benchmark_repetitions=3 --benchmark_report_aggregates_only=true >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
# of NAME: median of evaluations a second
of() { jq -r --arg name "$1" '.benchmarks[] | select(.run_name == $name and .aggregate_name == "median") | .evaluations_per_second' "$work/out.json"; }
master=$(of dispatch/20k)
floor=$(of dispatch_floor/20k)
printf '%-46s %9.0f evaluations/s\n' "evograsp, 20 kB a genome, 2 workers" "$master" \
  "bare ROUTER/DEALER and protobuf, one a message" "$floor"
awk -v m="$master" -v f="$floor" 'BEGIN { printf "%-46s %9.2f of the floor\n", "", m / f }'
$peers || exit 0
if ! /usr/bin/python3 -c 'import distributed' 2>/dev/null; then
  echo "Dask: not compared, python3-distributed is not installed (apt-get install python3-distributed)"
  exit 0
fi
dask=$(/usr/bin/python3 bench/dask_submit.py)
printf '%-46s %9.0f evaluations/s\n' "Dask $(/usr/bin/python3 -c 'import distributed; print(distributed.__version__)'), submit()" "$dask"
awk -v m="$master" -v d="$dask" 'BEGIN { printf "%-46s %9.0f times Dask\n", "", m / d }'
