#!/usr/bin/env bash
# A study's folder as it is published: its page with PNG plots, its tables, and the data of runs and tests.
#   bench/publish.sh STUDY_DIR OUT_DIR
# Left out are run folders, the HTML page, and data of single generations when they are larger than 200 kB.
set -euo pipefail
from=${1:?usage: publish.sh STUDY_DIR OUT_DIR}
to=${2:?usage: publish.sh STUDY_DIR OUT_DIR}
mkdir -p "$to"
rm -f "$to"/*.png "$to"/*.csv "$to"/*.json
cp "$from"/*.png "$from"/*.csv "$from"/*.json "$to"
find "$to" -name 'generations.*' -size +200k -delete
sed 's/\.svg)/.png)/' "$from/README.md" >"$to/README.md"
if [ ! -e "$to/generations.csv" ] || [ ! -e "$to/generations.json" ]; then
  rm -f "$to"/generations.*
  # shellcheck disable=SC2016  # the page's own backquotes
  sed -i 's/, `generations` (a row a generation)//' "$to/README.md"
fi
