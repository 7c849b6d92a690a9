#!/usr/bin/env bash
# Fails when the sources leave the layout: more than 35 files in a folder, more than five files (besides
# CMakeLists.txt and layer.h) in a top-level folder, an _impl.h, a header over 250 lines or a source over 500.
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
done < <(find scenes sim perception grasp eval tests -path tests/support/planted_layout -prune -o \
  \( -name '*.h' -o -name '*.cpp' \) -print 2>/dev/null)
[ -z "$problems" ] && exit 0
printf '%s' "$problems"
exit 1
