# What the cases share: how they fail, and small scenarios in their folder.

fail() {
  echo "FAIL ($name): $*" >&2
  for log in "$work"/*.err; do [ -f "$log" ] && sed "s|^|  $(basename "$log"): |" "$log" >&2; done
  exit 1
}

# expect STATUS COMMAND... : runs it with stdout in last.out and stderr in last.err.
expect() {
  local wanted=$1
  shift
  "$@" >last.out 2>last.err
  local status=$?
  [ "$status" = "$wanted" ] || fail "exit $status, expected $wanted, of: $*"
}
same() { cmp -s "$1" "$2" || fail "$1 and $2 differ"; }

# A small bin of convex parts with true poses, quick and without a network.
small=(--set estimator.name=oracle --set estimator.noise_mm=1)
cat >small.yaml <<'YAML'
seed: 7
trials: 4
objects:
  - {name: rod, count: 3}
  - {name: flange, count: 2}
YAML
echo "objects: [{name: rod, count: 3}]" >rods.yaml

# A run whose poses are so wrong that picks are lost to them.
noisy=(--set estimator.name=oracle --set estimator.noise_mm=9 --trials 2 --pictures 0)

# refused WORDS COMMAND... : exit 1 and one line on stderr, besides progress, that holds the words.
refused() {
  local words=$1
  shift
  expect 1 "$@"
  [ "$(grep -c '^pickbed: ' last.err)" = 1 ] || fail "not one line of: $*"
  grep '^pickbed: ' last.err | grep -qF -- "$words" || fail "'$words' is not said of: $*"
}

# brick SCALE: an OBJ of 60 x 40 x 20 units.
brick() {
  for z in -10 10; do for y in -20 20; do for x in -30 30; do
    echo "v $((x * $1)) $((y * $1)) $((z * $1))"
  done; done; done
  printf 'f %s\n' '1 3 4 2' '5 6 8 7' '1 2 6 5' '3 7 8 4' '1 5 7 3' '2 4 8 6'
}
