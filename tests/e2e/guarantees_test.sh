#!/usr/bin/env bash
# Every test that docs/GUARANTEES.md names exists.
source "$(dirname "$0")/lib.sh"

tests=$here/..
named=$(grep -oE '`[A-Z][A-Za-z]+\.[A-Z][A-Za-z0-9]+`' "$tests/../docs/GUARANTEES.md" | tr -d '`' | sort -u)
[ "$(wc -l <<<"$named")" -gt 20 ] || fail "no tests are named"
while IFS=. read -r suite test; do
  grep -rqE "TEST(_F|_P)?\($suite, $test\)" "$tests" --include='*.cpp' || fail "there is no test $suite.$test"
done <<<"$named"
finish
