#!/bin/bash
# Tests fuzz.sh with a program in place of the fuzz targets: one target ends well, one has a finding, and
# one ends without an input.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
export FUZZ_BUILD
FUZZ_BUILD=$(mktemp -d)
trap 'rm -rf "$FUZZ_BUILD"' EXIT
cat >"$FUZZ_BUILD/pickbed_fuzzer" <<'END'
#!/bin/bash
[ "$1" != --list ] || { printf 'good\nbad\nbroken\n'; exit; }
target=${1#--target=}
for argument in "$@"; do
  case $argument in
    --seeds=*) mkdir -p "${argument#--seeds=}"; head -c 200000 /dev/zero >"${argument#--seeds=}/seed_0000"; exit ;;
    -artifact_prefix=*) prefix=${argument#-artifact_prefix=} ;;
    -max_total_time=*) echo "time ${argument#*=}" ;;
    -max_len=*) echo "length ${argument#*=}" ;;
  esac
done
[ "$target" != broken ] || exit 3
until times >"$FUZZ_BUILD/times" && [[ $(<"$FUZZ_BUILD/times") > 0m0.2 ]]; do :; done  # takes CPU time
printf 'stat::number_of_executed_units: 1234\nstat::new_units_added:          5\n'
[ "$target" != bad ] || { sleep 0.02; echo x >"${prefix}crash-0a"; echo x >"${prefix}slow-unit-0b"; exit 77; }
END
chmod +x "$FUZZ_BUILD/pickbed_fuzzer"

fail() { echo "FAILED: $1"; cat "$FUZZ_BUILD/output"; exit 1; }
# run STATUS ARGUMENTS...
run() {
  local expected=$1 status=0
  shift
  "$here/fuzz.sh" "$@" >"$FUZZ_BUILD/output" 2>&1 || status=$?
  [ $status = "$expected" ] || fail "status $status in place of $expected"
}
has() { grep -qE -- "$1" "$FUZZ_BUILD/output" || fail "no '$1'"; }

run 0 2 good
has '^good +1234 +5 +0 +[0-9.]*[1-9][0-9.]*$'
grep -q 'time 120' "$FUZZ_BUILD/findings/good.log" || fail "the time is not shared"
grep -q 'length 300000' "$FUZZ_BUILD/findings/good.log" || fail "the seed is cut"
run 1 2
has '^target +runs +new inputs +findings +CPU s$'
has '^good +1234 +5 +0 +[0-9.]*[1-9][0-9.]*$'
has "^bad: FAILED on $FUZZ_BUILD/findings/bad-crash-0a, see "
has '^bad +1234 +5 +1 +[0-9.]+$'
has '^broken: FAILED without an input, see '
has '^broken +0 +0 +1 +[0-9.]+$'
grep -q 'time 40' "$FUZZ_BUILD/findings/good.log" || fail "the time is not shared"
run 0 2 good  # an earlier finding of another target does not count
[ "$(wc -l <"$FUZZ_BUILD/cpu_seconds")" = 5 ] || fail "cpu_seconds has not a line of each share"
has '^CPU hours of all calls: 0.00$'
run 1 many
has 'whole number of minutes'
