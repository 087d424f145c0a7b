# What the scripts share. Usage: NAME_test.sh BIN. Each runs in a folder of its own, which goes when it ends.
# shellcheck shell=bash
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$(cd "${1:?usage: NAME_test.sh BIN}" && pwd)
export evograsp=$bin/evograsp server=$bin/evograsp-server worker=$bin/evograsp-worker
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
ln -s "$here/../../configs" configs
export HOME=$folder
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect CODE COMMAND...: runs it, standard output in out, standard error in err.
expect() {
  local wanted=$1 code
  shift
  "$@" >out 2>err
  code=$?
  [ "$code" -eq "$wanted" ] && return 0
  fail "'$*' ended with $code, not $wanted"
  tail -n 20 out err
}

# wait_for_endpoint LOG: the address at which a server that logs there takes workers.
wait_for_endpoint() {
  local i
  for ((i = 0; i < 200; i++)); do
    grep -o -m1 'tcp://[0-9.]*:[0-9][0-9]*' "$1" && return
    sleep 0.1
  done
  fail "no server: $(cat "$1")" >&2
}

finish() {
  [ "$failures" -eq 0 ] && echo "passed"
  exit "$failures"
}
