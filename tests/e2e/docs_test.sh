#!/usr/bin/env bash
# docs/CLI.md says what the programs' own --help says.
source "$(dirname "$0")/lib.sh"

expect 0 "$here/../../deploy/docs.sh" --check "$bin"
grep -q '^## evograsp-worker' "$here/../../docs/CLI.md" || fail "docs/CLI.md leaves a program out"
finish
