#!/usr/bin/env bash
# Fails when the sources leave the layout:
# - more than 35 files in a folder, or more than five (besides CMakeLists.txt and layer.h) in a top-level folder
# - an _impl.h, a header over 250 lines or a source over 500
# - a header under 15 lines without a reason in tests/short_headers.txt
# - a source that no test names and that has no reason in tests/untested_sources.txt. A test names it by the
#   name of the test file, or by an #include of its header.
# - a test file that tests/CMakeLists.txt does not name, so that it is never built
# - two types with one qualified name
# - the name of a file that is written or read, in two places
# Each line of the two lists has a path, which may be a pattern, and a reason. An entry without a file is an
# error as well.
#
#   check_layout.sh ROOT
set -u
cd "$1" || exit 2
problems=""
say() { problems+="$1"$'\n'; }
for top in scenes sim perception grasp eval; do
  [ -d "$top" ] || continue
  flat=$(find "$top" -maxdepth 1 -type f ! -name CMakeLists.txt ! -name layer.h | wc -l)
  [ "$flat" -le 5 ] || say "$top: $flat files beside CMakeLists.txt; move them into sub-folders"
done
while IFS= read -r folder; do
  files=$(find "$folder" -maxdepth 1 -type f | wc -l)
  [ "$files" -le 35 ] || say "$folder: $files files; split the folder by concept"
done < <(find scenes sim perception grasp eval tests -type d 2>/dev/null)
while IFS= read -r file; do
  lines=$(wc -l <"$file")
  case "$file" in
    *_impl.h) say "$file: name it by its concept" ;;
    *.h) [ "$lines" -le 250 ] || say "$file: $lines lines; a header has up to 250" ;;
    *.cpp) [ "$lines" -le 500 ] || say "$file: $lines lines; a source has up to 500" ;;
  esac
done < <(find scenes sim perception grasp eval tests -path "tests/support/planted_*" -prune -o \
  \( -name '*.h' -o -name '*.cpp' \) -print 2>/dev/null)
# check_listed LIST MESSAGE FILE...: each file needs a line in LIST, and each line a file.
check_listed() {
  local list=$1 message=$2 pattern reason file
  local -A unused=()
  shift 2
  local -a patterns=()
  if [ -f "$list" ]; then
    while read -r pattern reason; do
      case "$pattern" in '' | '#'*) continue ;; esac
      [ -n "$reason" ] || say "$list: $pattern has no reason"
      patterns+=("$pattern")
      unused[$pattern]=1
    done <"$list"
  fi
  for file in "$@"; do
    local listed=""
    for pattern in "${patterns[@]}"; do
      # shellcheck disable=SC2053
      [[ $file == $pattern ]] && listed=1 && unset "unused[$pattern]"
    done
    [ -n "$listed" ] || say "$file: $message"
  done
  for pattern in "${!unused[@]}"; do say "$list: $pattern is needless"; done
}

short=()
while read -r lines file; do
  [ "$lines" -lt 15 ] && short+=("$file")
done < <(find scenes sim perception grasp eval -name '*.h' -exec wc -l {} \; 2>/dev/null | sort -k2)
check_listed tests/short_headers.txt "under 15 lines; merge it or give a reason in tests/short_headers.txt" \
  "${short[@]}"

declare -A included=()
while read -r header; do included[$header]=1; done < <(
  grep -rhoE --include='*.cpp' --include='*.h' '^#include "(scenes|sim|perception|grasp|eval)/[^"]+"' tests 2>/dev/null |
    cut -d'"' -f2 | sort -u)
untested=()
while IFS= read -r file; do
  [ -f "tests/${file%.cpp}_test.cpp" ] || [ -n "${included[${file%.cpp}.h]:-}" ] || untested+=("$file")
done < <(find scenes sim perception grasp eval -name '*.cpp' 2>/dev/null | sort)
check_listed tests/untested_sources.txt "named by no test; test it or give a reason in tests/untested_sources.txt" \
  "${untested[@]}"

while IFS= read -r file; do
  grep -qsF "${file#tests/}" tests/CMakeLists.txt || say "$file: add it to tests/CMakeLists.txt; it is not built"
done < <(find tests -path "tests/support" -prune -o -name '*_test.cpp' -print 2>/dev/null | sort)

# Definitions begin in the first column, because namespaces are not indented. "}" in the first column after a
# namespace comment ends a namespace.
while IFS= read -r line; do say "$line"; done < <(
  find scenes sim perception grasp eval \( -name '*.h' -o -name '*.cpp' \) 2>/dev/null | LC_ALL=C sort | xargs -r awk '
    FNR == 1 { depth = 0 }
    /^namespace .*\{$/ || /^namespace \{$/ { name = $2; sub(/\{$/, "", name); space[++depth] = name == "" ? "(private)" : name; next }
    /^\}  \/\/ namespace/ { if (depth > 0) --depth; next }
    /^(class|struct|enum|union) / && (/\{/ || !/;/) {
      i = 2
      while ($i == "class" || $i == "struct" || $i ~ /^(alignas|\[\[)/) ++i
      type = $i
      sub(/[:{].*$/, "", type)
      if ($i ~ /::/) next  # defines a member of a class
      qualified = ""
      for (j = 1; j <= depth; ++j) { if (space[j] == "(private)") next; qualified = qualified space[j] "::" }
      qualified = qualified type
      if (qualified in seen) print FILENAME ":" FNR ": " qualified " is also defined in " seen[qualified]
      else seen[qualified] = FILENAME
    }')

# A name is a constant in a header, or the name of a file in "folder / NAME".
named=$(grep -rhoE --include='*.cpp' --include='*.h' '(char k[A-Za-z]+\[\] =|[a-z_)] /) "[a-z_]+\.(csv|html|json|md|sqlite|yaml)"' \
  scenes sim perception grasp eval 2>/dev/null | cut -d'"' -f2 | sort -u)
while IFS= read -r name; do
  places=$(grep -rnF --include='*.cpp' --include='*.h' "$name" scenes sim perception grasp eval 2>/dev/null | sed -E 's,//.*,,' |
    grep -E "\"([^\"]*[^A-Za-z0-9_\"])?${name//./\\.}")
  [ "$(grep -c . <<<"$places")" -le 1 ] || say "$(cut -d: -f1 <<<"$places" | paste -sd' '): each writes \"$name\"; use the constant"
done <<<"$named"

[ -z "$problems" ] && exit 0
printf '%s' "$problems"
exit 1
