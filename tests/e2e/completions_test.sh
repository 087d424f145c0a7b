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

# zsh and fish, where they are installed, are asked for the line that Tab makes.
expect 0 "$evograsp" completions zsh
cp out complete.zsh
expect 0 "$evograsp" completions fish
cp out complete.fish
zsh_line() { timeout 60 zsh -f "$here/zsh_complete.zsh" complete.zsh "$1"; }
fish_words() { HOME=$folder timeout 60 fish --no-config -c "source complete.fish; complete -C\"$1\"" | cut -f1 | grep . | head -n 3 | xargs; }
if command -v zsh >/dev/null; then
  [ "$(zsh_line 'evograsp tra')" = 'evograsp train ' ] || fail "zsh: tra: $(zsh_line 'evograsp tra')"
  [ "$(zsh_line 'evograsp train qui')" = 'evograsp train quick ' ] || fail "zsh: train qui"
  [ "$(zsh_line 'evograsp validate --sh')" = 'evograsp validate --show ' ] || fail "zsh: validate --sh"
  [ "$(zsh_line 'evograsp help val')" = 'evograsp help validate ' ] || fail "zsh: help val"
fi
if command -v fish >/dev/null; then
  [ "$(fish_words 'evograsp tra')" = train ] || fail "fish: tra: $(fish_words 'evograsp tra')"
  [ "$(fish_words 'evograsp train qui')" = quick ] || fail "fish: train qui"
  [ "$(fish_words 'evograsp validate --sh')" = --show ] || fail "fish: validate --sh"
  [ "$(fish_words 'evograsp help val')" = validate ] || fail "fish: help val"
fi
finish
