#!/usr/bin/env bash
# Builds the documentation site in a temporary folder and opens it in headless Chromium. The front page must show
# its heading, and the search box must find a word of another page. Exits with 77 if a program is not installed.
#
#   check_site.sh ROOT [WORD]    WORD: searched instead of a word of metrics.md
set -eu
for program in mkdocs chromium node; do
  command -v $program >/dev/null || { echo "the package of $program is missing; see packages.txt"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
here=$(cd "$(dirname "$0")" && pwd)
cd "$1"  # pages quote files relative to it
mkdocs build --strict --quiet -f docs/mkdocs.yml -d "$work/site"
node "$here/check_site.mjs" "$work/site" pickbed "${2:-jackknife}" metrics
