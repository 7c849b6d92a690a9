# Helpers shared by all cases, and small scenarios in the working folder.

fail() {
  echo "FAIL ($name): $*" >&2
  for log in "$work"/*.err; do [ -f "$log" ] && sed "s|^|  $(basename "$log"): |" "$log" >&2; done
  exit 1
}

# expect STATUS COMMAND...: runs the command and fails unless it exits with STATUS. Its stdout goes to
# last.out and its stderr to last.err.
expect() {
  local wanted=$1
  shift
  "$@" >last.out 2>last.err
  local status=$?
  [ "$status" = "$wanted" ] || fail "exit status $status, expected $wanted: $*"
}
# same FILE FILE: fails unless both files have the same bytes.
same() { cmp -s "$1" "$2" || fail "$1 and $2 differ"; }

# A quick run without a network: a small bin, and ground truth poses with 1 mm noise.
small=(--set estimator.name=oracle --set estimator.noise_mm=1)
cat >small.yaml <<'YAML'
seed: 7
trials: 4
objects:
  - {name: rod, count: 3}
  - {name: flange, count: 2}
YAML
echo "objects: [{name: rod, count: 3}]" >rods.yaml

# A run with pose errors so large that picks fail.
noisy=(--set estimator.name=oracle --set estimator.noise_mm=9 --trials 2 --pictures 0)

# refused WORDS COMMAND...: expects exit status 1 and, besides progress, one line on stderr with the
# words.
refused() {
  local words=$1
  shift
  expect 1 "$@"
  [ "$(grep -c '^pickbed: ' last.err)" = 1 ] || fail "not exactly one error line: $*"
  grep '^pickbed: ' last.err | grep -qF -- "$words" || fail "no error with '$words': $*"
}

# has_template: whether the program was built with its page template, which needs the npm registry.
has_template() { [ -s "$(dirname "$pickbed")/report/page.html" ]; }

# page FILE [WORDS]: expects that the last command wrote this page, with the words. Without a page
# template, expects no page and one line on stderr with the reason.
page() {
  if has_template; then
    [ -s "$1" ] || fail "no $1"
    grep -qF -- "${2:-}" "$1" || fail "no '$2' in $1"
  else
    [ ! -e "$1" ] || fail "a page was written without a template: $1"
    [ "$(grep -c "^pickbed: .*$1 is not written" last.err)" = 1 ] || fail "no reason why $1 is missing"
  fi
}

# brick SCALE: prints an OBJ box of 60 x 40 x 20 units, multiplied by SCALE.
brick() {
  for z in -10 10; do for y in -20 20; do for x in -30 30; do
    echo "v $((x * $1)) $((y * $1)) $((z * $1))"
  done; done; done
  printf 'f %s\n' '1 3 4 2' '5 6 8 7' '1 2 6 5' '3 7 8 4' '1 5 7 3' '2 4 8 6'
}
