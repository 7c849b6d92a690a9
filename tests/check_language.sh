#!/usr/bin/env bash
# Fails when a comment, a string literal or an identifier uses one of the forms that the style guide forbids,
# such as a sentence that begins with "Of". Prints file, line and text of each.
#
#   check_language.sh ROOT
set -u
cd "$1" || exit 2
forbidden='\bthat of\b|\bthose (that|of)\b|\bwhich is what\b|\b([Tt]ells?|[Tt]old)\b|\b([Ss]tands?|[Ss]tood)\b'
forbidden+='|\b([Ll]ies?)\b|\b[Aa]lone\b|\b[Nn]obody\b|\b[Ww]hoever\b|\bof no (time|use)\b'
in_comments="(//|\\. )[ ]*Of [a-zA-Z]|$forbidden"
# Private words of earlier versions, which messages and help must not use.
in_strings="(\"|\\. )Of [a-zA-Z]|$forbidden|\\b([Bb]elieved|[Bb]lamed?|fates?|lessons?|look-alikes?|polish(ed)?)\\b"
in_strings+='|\bforeign (parts?|objects?|shapes?)\b|\b(a|the|each|every|any|no|of|wanted|all) parts?\b|\bpart '"'"
# Strings that are stored, hashed, compared or drawn from as they are.
kept='Rng::Derive|(TABLE|UPDATE) (fates|rejections)|Renamed(Key|Value)|\{"(fingers|palm) meets? a part"|"estimate/|"(alone|fates?|lessons?|polish)"'

sources() {
  find scenes sim perception grasp eval tests -path 'tests/support/planted_*' -prune -o \
    \( -name '*.h' -o -name '*.cpp' \) -print0 2>/dev/null
}
comments() {
  sources | xargs -0 -r grep -nHE '//' | grep -vE '"[^"]*//' |
    sed -E 's,^([^:]*:[0-9]+:)[^/]*(/[^/][^/]*)*//,\1//,' |
    grep -E "^[^:]*:[0-9]+:.*($in_comments)"
}
# Prints only the literals of each line that has some. Adjacent literals of a line stay separate.
strings() {
  sources | xargs -0 -r grep -nHE '"' | grep -vE "$kept|^[^:]*:[0-9]+: *(//|#include)" |
    awk '{
      match($0, /^[^:]*:[0-9]+:/)
      place = substr($0, 1, RLENGTH); rest = substr($0, RLENGTH + 1); literals = ""
      while (match(rest, /"([^"\\]|\\.)*"|\/\//)) {
        if (substr(rest, RSTART, 2) == "//") break
        literals = literals " " substr(rest, RSTART, RLENGTH)
        rest = substr(rest, RSTART + RLENGTH)
      }
      if (literals != "") print place literals
    }' | grep -E "^[^:]*:[0-9]+:.*($in_strings)"
}
# Prints each line of code that has one of these words as an identifier or within one.
identifiers() {
  local words='parts?|piles?|twins?|tells?|told|looks?|looked|aims?|aimed|tries|charge[ds]?|lessons?|middle'
  local capitals='Parts?|Piles?|Twins?|Tells?|Told|Looks?|Looked|Aims?|Aimed|Tries|Charge[ds]?|Lessons?|Middle'
  # Names of formats, of libraries and of settings that are stored, and established terms.
  local allowed='GlbParts?|glb_parts?|[Pp]art_?[Ff]amil[A-Za-z]*|Look(At|Up|Ahead)[A-Za-z]*|kPile|middleCols|m_least[A-Za-z]*'
  sources | xargs -0 -r grep -nHE '[a-z]' | grep -vE '^[^:]*:[0-9]+: *(//|#include|TEST)' |
    sed -E "s/\"([^\"\\\\]|\\\\.)*\"//g; s,//.*,,; s/\\<($allowed)\\>//g" |
    grep -E "^[^:]*:[0-9]+:((.*[^A-Za-z])?($words|least|most)|.*($capitals|kLeast|kMost))([^a-z]|\$)"
}
yaml_comments() {
  find assets scenes -name '*.yaml' -print0 2>/dev/null | xargs -0 -r grep -nHE '#' |
    grep -E "^[^:]*:[0-9]+:[^#]*#(.*\\.)? *(Of [a-zA-Z]|.*($forbidden|\\bparts?\\b))"
}
found=$(comments; strings; identifiers; yaml_comments)
[ -z "$found" ] && exit 0
printf '%s\n' "$found" "forbidden forms: $(printf '%s\n' "$found" | wc -l)"
exit 1
