#!/usr/bin/env bash
# Checks that the headers of the five folders are complete and compatible.
#
#   check_headers.sh together ROOT COMPILE_COMMANDS COMPILER   compiles all headers in one translation unit;
#                                                              finds two definitions of one name
#   check_headers.sh each ROOT COMPILE_COMMANDS COMPILER       finds a header that misses an #include
#
# The sources cannot show a missing #include, because they are compiled in groups and with a precompiled
# header. To compile each header in a process of its own takes five minutes. "each" takes less than one:
# - Standard headers and Eigen: a table says which header declares a name. A header that uses the name must
#   include this header, also through our other headers. So these headers may be precompiled.
# - Everything else is compiled. A header may follow one that it includes, since it would see the same
#   declarations anyway. So headers are compiled in chains in which each includes the one before it.
# - A failing static_assert ends each chain. With -Wfatal-errors the compiler stops there and does not
#   instantiate the templates of all headers.
set -u
export LC_ALL=C
mode=$1 compiler=$4
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
  # Writes the chains, one per line, and a line for each name without its standard header.
  awk -v chains="$work/chains" '
    BEGIN {
      # name (a regular expression) and headers that declare it
      split("std::vector=vector std::string[^_a-z]=string std::string_view=string_view,string " \
        "std::(optional|nullopt)=optional std::function[^a-z]=functional std::map=map std::set[^_a-z]=set " \
        "std::((unique|shared|weak)_ptr|make_(unique|shared))=memory std::array=array std::span=span " \
        "std::filesystem=filesystem [^_a-z]u?int(8|16|32|64)_t=cstdint std::chrono=chrono " \
        "std::numeric_limits=limits std::exception_ptr=exception std::(runtime|logic)_error=stdexcept " \
        "std::(clamp|min|max|sort)[({]=algorithm std::(sqrt|sin|cos|acos|atan2|hypot|pow|isfinite)=cmath " \
        "std::tuple=tuple std::unordered_map=unordered_map std::variant=variant std::mutex=mutex " \
        "std::thread=thread std::atomic=atomic std::numbers=numbers std::initializer_list=initializer_list " \
        "Eigen::=Eigen/Core,Eigen/Geometry Eigen::(Quaternion|AngleAxis|Isometry|Affine)=Eigen/Geometry",
        rows, " ")
      for (i in rows) { at = index(rows[i], "="); declared_by[substr(rows[i], 1, at - 1)] = substr(rows[i], at + 1) }
    }
    FNR == 1 { header[++count] = FILENAME }
    /^#include/ { gsub(/[<>"]/, "", $2); includes[FILENAME] = includes[FILENAME] " " $2; next }
    { sub(/\/\/.*/, ""); for (name in declared_by) if ($0 ~ name && !((FILENAME, name) in used)) used[FILENAME, name] = FNR }
    function visit(root, h,   n, next_of, i) {
      n = split(includes[h], next_of, " ")
      for (i = 1; i <= n; ++i) {
        if ((root, next_of[i]) in inside) continue
        inside[root, next_of[i]] = 1
        size[root] += next_of[i] in includes
        visit(root, next_of[i])
      }
    }
    END {
      for (i = 1; i <= count; ++i) { includes[header[i]] = includes[header[i]] ""; size[header[i]] = 0 }
      for (i = 1; i <= count; ++i) visit(header[i], header[i])
      for (use in used) {
        split(use, part, SUBSEP)
        found = 0
        n = split(declared_by[part[2]], any, ",")
        for (i = 1; i <= n; ++i) found = found || (part[1], any[i]) in inside
        if (!found) printf "%s:%d: error: %s without <%s>\n", part[1], used[use], part[2], any[1]
      }
      for (s = 0; s <= count; ++s) for (i = 1; i <= count; ++i) {
        h = header[i]
        if (size[h] != s) continue
        found = 0
        for (c = 1; c <= chain_count; ++c) {
          if ((h, end[c]) in inside && (!found || size[end[c]] > size[end[found]])) found = c
        }
        if (!found) found = ++chain_count
        chain[found] = chain[found] " " h
        end[found] = h
      }
      for (c = 1; c <= chain_count; ++c) print chain[c] >chains
    }' "${headers[@]}" >"$work/errors"
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
  xargs -P "$(nproc)" -I{} bash -c 'compile {}' <"$work/chains" | grep error: |
    grep -v "all headers read" >>"$work/errors"
fi
LC_ALL=C sort -u "$work/errors"
[ ! -s "$work/errors" ]
