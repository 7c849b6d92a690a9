#!/bin/bash
# Runs all fuzz targets under libFuzzer with the sanitizers, one after the other, each for an equal share of
# the time. Exit status 1: a target failed, and the inputs are in build/fuzz/findings.
#   fuzz.sh MINUTES [TARGET...]
# Without targets, all.
# The corpora in build/fuzz/corpus grow from call to call.
set -u
root=$(cd "$(dirname "$0")/../.." && pwd)
minutes=$1
shift
build=$root/build/fuzz
fuzzer=$build/pickbed_fuzzer
if [ $# -gt 0 ]; then targets=("$@"); else mapfile -t targets < <("$fuzzer" --list); fi
[ ${#targets[@]} -gt 0 ] || { echo "fuzz.sh: $fuzzer lists no targets" >&2; exit 1; }
seconds=$((minutes * 60 / ${#targets[@]}))
mkdir -p "$build/findings"
# Third-party libraries are not instrumented, which needs these options:
# - detect_container_overflow=0: a std::vector that they fill seems to be written beyond its end.
# - detect_leaks=0: what they keep until the end of the process counts as a leak of each input.
# - allocator_may_return_null=1: a refused allocation throws std::bad_alloc, as without the sanitizer.
export ASAN_OPTIONS=detect_container_overflow=0:detect_leaks=0:allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1
export ASAN_SYMBOLIZER_PATH=${ASAN_SYMBOLIZER_PATH:-/usr/bin/llvm-symbolizer-16}
failed=0
for target in "${targets[@]}"; do
  corpus=$build/corpus/$target
  [ -d "$corpus" ] || "$fuzzer" --target="$target" --seeds="$corpus" || exit 1
  folders=("$corpus")
  [ ! -d "$root/tests/fuzz/failed/$target" ] || folders+=("$root/tests/fuzz/failed/$target")
  log=$build/findings/$target.log
  "$fuzzer" --target="$target" "${folders[@]}" -max_total_time=$((seconds > 1 ? seconds : 1)) -timeout=30 \
    -rss_limit_mb=4096 -max_len=100000 -print_final_stats=1 -artifact_prefix="$build/findings/$target-" \
    >"$log" 2>&1 || { failed=1; echo "$target: FAILED, see $log"; }
  echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs in $seconds s"
done
exit $failed
