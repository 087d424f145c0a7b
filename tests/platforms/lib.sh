# What the tests of platforms share, beside tests/e2e/lib.sh. Sourced.
# shellcheck shell=bash
platforms=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$platforms/../e2e/lib.sh"
here=$platforms

# cannot REASON: ends the test as one that this machine cannot run (ctest shows it as skipped, with the reason).
cannot() {
  echo "CANNOT RUN HERE: $*"
  exit 77
}

# within SECONDS COMMAND...: until it succeeds.
within() {
  local deadline=$((SECONDS + $1))
  shift
  until "$@"; do
    [ $SECONDS -lt "$deadline" ] || return 1
    sleep 0.1
  done
}
