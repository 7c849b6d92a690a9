#!/bin/bash
# End-to-end checks of the program as a user runs it.
#   e2e.sh PICKBED CASE
# CASE is a function of cases/*.sh whose name begins with a letter. Each case runs in its own temporary
# folder. A failed case prints a message and exits with 1.
set -u
here=$(cd "$(dirname "$0")" && pwd)
pickbed=$1
name=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/pickbed_e2e_XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export PATH=/usr/bin:$PATH  # Debian's Python has the packages of packages.txt

source "$here/common.sh"
for file in "$here"/cases/*.sh; do source "$file"; done

"$name"
