#!/usr/bin/env bash
# docs/CLI.md from the programs' own --help.
#   deploy/docs.sh [BIN]           writes it
#   deploy/docs.sh --check [BIN]   fails when it is out of date
set -euo pipefail
check=false
if [ "${1:-}" = --check ]; then check=true; shift; fi
bin=$(cd "${1:-build/release/bin}" && pwd)
cd "$(dirname "$0")/.."

manual() {
  printf '# Command line\n\nWhat `--help` says, of every command. Exit codes: [EXIT-CODES.md](EXIT-CODES.md).\n'
  printf 'Completion for your shell: `source <(evograsp completions bash)` (or zsh, fish).\n'
  local command inner
  # Entries of the help stand two blanks in and begin with a letter; "First steps" follow them.
  for command in $("$bin/evograsp" --help | sed '/^First steps/,$d' | sed -nE 's/^  ([a-z]+) .*/\1/p'); do
    printf '\n## evograsp %s\n\n```\n' "$command"
    "$bin/evograsp" help "$command"
    printf '```\n'
    for inner in $("$bin/evograsp" help "$command" | sed -n '/^Subcommands:/,/^$/p' | sed -nE 's/^  ([a-z]+) .*/\1/p'); do
      printf '\n## evograsp %s %s\n\n```\n' "$command" "$inner"
      "$bin/evograsp" help "$command" "$inner"
      printf '```\n'
    done
  done
  for command in evograsp-server evograsp-worker; do
    printf '\n## %s\n\n```\n' "$command"
    "$bin/$command" --help
    printf '```\n'
  done
}

if $check; then
  diff docs/CLI.md <(manual) || { echo "docs/CLI.md is out of date: run deploy/docs.sh" >&2; exit 1; }
else
  manual >docs/CLI.md
fi
