#!/usr/bin/env bash
# Makes the API reference in a temporary folder. Fails on a warning of doxygen, and if comments of headers are
# missing in the pages. Exits with 77 if doxygen is not installed.
#
#   check_api.sh ROOT [INPUT]    INPUT: the files to read instead of those of docs/doxygen/Doxyfile
set -eu
cd "$1"
command -v doxygen >/dev/null || { echo "the package doxygen is missing; see group docs in packages.txt"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
{
  cat docs/doxygen/Doxyfile
  echo "OUTPUT_DIRECTORY = $work"
  echo "HTML_OUTPUT = api"
  [ $# -lt 2 ] || echo "INPUT = $2"
} >"$work/Doxyfile"
doxygen "$work/Doxyfile"
# A comment before a declaration, one behind a member, and one in a class.
for text in "Drops scenes until one has no fault" "index into the ObjectSet" "Returns the camera of a window"; do
  grep -rqF "$text" "$work/api" || { echo "the comment \"$text\" is not in the pages"; exit 1; }
done
