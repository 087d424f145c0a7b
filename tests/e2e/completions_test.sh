#!/usr/bin/env bash
# bash really completes what the script says.
source "$(dirname "$0")/lib.sh"

expect 0 "$evograsp" completions bash
# shellcheck disable=SC1091
source ./out
complete_words() { # WORDS...: sets COMPREPLY as if Tab were pressed after the last
  COMP_WORDS=(evograsp "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _evograsp
}
complete_words tra
[ "${COMPREPLY[*]}" = train ] || fail "tra: ${COMPREPLY[*]}"
complete_words train qui
[ "${COMPREPLY[*]}" = quick ] || fail "train qui: ${COMPREPLY[*]}"
complete_words validate --sh
[ "${COMPREPLY[*]}" = --show ] || fail "validate --sh: ${COMPREPLY[*]}"
complete_words help val
[ "${COMPREPLY[*]}" = validate ] || fail "help val: ${COMPREPLY[*]}"
for shell in zsh fish; do
  expect 0 "$evograsp" completions $shell
  command -v $shell >/dev/null || continue
  $shell -n out || fail "$shell cannot read its script"
done
finish
