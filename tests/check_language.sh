#!/usr/bin/env bash
# Fails when a comment uses one of the forms that the style guide forbids, such as a sentence that begins
# with "Of". Prints file, line and text of each.
#
#   check_language.sh ROOT
set -u
cd "$1" || exit 2
forbidden='(//|\. )[ ]*Of [a-zA-Z]|\bthat of\b|\bthose (that|of)\b|\bwhich is what\b|\b([Tt]ells?|[Tt]old)\b'
forbidden+='|\b([Ss]tands?|[Ss]tood)\b|\b([Ll]ies?)\b|\b[Aa]lone\b|\b[Nn]obody\b|\b[Ww]hoever\b|\bof no (time|use)\b'
found=$(find scenes sim perception grasp eval tests -path tests/support/planted_language -prune -o \
  \( -name '*.h' -o -name '*.cpp' \) -print0 2>/dev/null |
  xargs -0 -r grep -nHE '//' | grep -vE '"[^"]*//' |
  sed -E 's,^([^:]*:[0-9]+:)[^/]*(/[^/][^/]*)*//,\1//,' | grep -E "^[^:]*:[0-9]+:.*($forbidden)")
[ -z "$found" ] && exit 0
printf '%s\n' "$found" "forbidden forms: $(printf '%s\n' "$found" | wc -l)"
exit 1
