#!/usr/bin/env bash
# Checks that the headers of the five folders are complete and compatible.
#
#   check_headers.sh together ROOT COMPILE_COMMANDS COMPILER   compiles all headers in one translation unit;
#                                                              finds two definitions of one name
#   check_headers.sh each ROOT COMPILE_COMMANDS COMPILER       finds a header that misses an #include
#
# The sources cannot show a missing #include, because they are compiled in groups and with a precompiled
# header. To compile each header in a process of its own takes five minutes. "each" takes less than one:
# - Standard headers, Eigen and libtorch: a table says which header declares a name. A header that uses the name
#   must include this header, also through our other headers. So the first two may be precompiled, and few units
#   read libtorch.
# - Everything else is compiled. A header may follow one that it includes, since it would see the same
#   declarations anyway, and one that has no name in common with it. header_units.py groups the headers.
# - A failing static_assert ends each unit. With -Wfatal-errors the compiler stops there and does not
#   instantiate the templates of all headers.
set -u
export LC_ALL=C
mode=$1 compiler=$4
tests=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
cd "$2" || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
folders=()
for folder in scenes sim perception grasp eval; do [ -d "$folder" ] && folders+=("$folder"); done
mapfile -t headers < <(find "${folders[@]}" -name '*.h' | LC_ALL=C sort)

# Include paths and definitions of the real build.
{
  echo "-std=c++20 -w -I."
  grep -E -- '"command".* -c [^ ]*/(scenes|sim|perception|grasp|eval)/' "$3" |
    grep -oE -- '-isystem [^ ]+|-D[A-Za-z0-9_]+(=[A-Za-z0-9_]+)?' | awk '!seen[$0]++'
} >"$work/flags"

if [ "$mode" = together ]; then
  printf '#include "%s"\n' "${headers[@]}" >"$work/all.cpp"
  "$compiler" "@$work/flags" -fsyntax-only "$work/all.cpp" 2>&1 | grep error: >"$work/errors"
else
  "$tests/header_units.py" "$work/units" "${headers[@]}" >"$work/errors" || exit 2
  grep -hoE '^#include <([a-z_]+|Eigen/[A-Z][a-z]+)>' "${headers[@]}" | sort -u >"$work/standard.h"
  "$compiler" "@$work/flags" -x c++-header "$work/standard.h" -o "$work/standard.h.gch" || exit 2
  export work compiler
  compile() {
    local text=$work/${1//\//_}.cpp
    printf '#include "%s"\n' "$@" >"$text"
    echo 'static_assert(false, "all headers read");' >>"$text"
    "$compiler" "@$work/flags" -fsyntax-only -Wfatal-errors -include "$work/standard.h" "$text" 2>&1
  }
  export -f compile
  xargs -P "$(nproc)" -I{} bash -c 'compile {}' <"$work/units" | grep error: |
    grep -v "all headers read" >>"$work/errors"
fi
LC_ALL=C sort -u "$work/errors"
[ ! -s "$work/errors" ]
