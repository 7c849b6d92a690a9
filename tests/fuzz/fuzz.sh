#!/bin/bash
# Runs fuzz targets under libFuzzer with the sanitizers, one after the other, each for an equal share of the
# time. A finding ends its target. The others still run. Exit status 1: there are findings.
#   fuzz.sh MINUTES [TARGET...]
# Without targets, all.
# The corpora in build/fuzz/corpus grow from call to call, and build/fuzz/cpu_seconds has the time of each
# call. FUZZ_BUILD is another folder for build/fuzz.
set -u
root=$(cd "$(dirname "$0")/../.." && pwd)
minutes=${1:-}
[[ $minutes =~ ^[0-9]+$ ]] || { echo "usage: fuzz.sh MINUTES [TARGET...], with a whole number of minutes" >&2; exit 1; }
shift
build=${FUZZ_BUILD:-$root/build/fuzz}
fuzzer=$build/pickbed_fuzzer
if [ $# -gt 0 ]; then targets=("$@"); else mapfile -t targets < <("$fuzzer" --list); fi
[ ${#targets[@]} -gt 0 ] || { echo "fuzz.sh: $fuzzer lists no targets" >&2; exit 1; }
seconds=$((minutes * 60 / ${#targets[@]}))
[ $seconds -gt 0 ] || seconds=1
mkdir -p "$build/findings"
# Third-party libraries are not instrumented, which needs these options:
# - detect_container_overflow=0: a std::vector that they fill seems to be written beyond its end.
# - detect_leaks=0: what they keep until the end of the process counts as a leak of each input.
# - allocator_may_return_null=1: a refused allocation throws std::bad_alloc, as without the sanitizer.
export ASAN_OPTIONS=detect_container_overflow=0:detect_leaks=0:allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1
export ASAN_SYMBOLIZER_PATH=${ASAN_SYMBOLIZER_PATH:-/usr/bin/llvm-symbolizer-16}

# statistic NAME LOG: a number that libFuzzer prints at its end, 0 if it printed none.
statistic() {
  local value
  value=$(sed -n "s/^stat::$1: *//p" "$2" | tail -n 1)
  echo "${value:-0}"
}

TIMEFORMAT="%U %S"  # of the fuzzer and its child processes
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
all_findings=0
rows=()
for target in "${targets[@]}"; do
  corpus=$build/corpus/$target
  log=$build/findings/$target.log
  echo "$target: $seconds s"
  # Each call, since the corpus may be of an earlier version.
  "$fuzzer" --target="$target" --seeds="$corpus" || { echo "$target: no seeds" >&2; exit 1; }
  folders=("$corpus")
  [ ! -d "$root/tests/fuzz/failed/$target" ] || folders+=("$root/tests/fuzz/failed/$target")
  # libFuzzer cuts longer inputs, and a file that is cut is refused before most of the code is reached.
  longest=$(find "$corpus" -name 'seed_*' -printf '%s\n' | sort -n | tail -n 1)
  touch "$work/begin"
  failed=0
  { time "$fuzzer" --target="$target" "${folders[@]}" -max_total_time=$seconds -timeout=30 -rss_limit_mb=4096 \
    -max_len=$((${longest:-0} + 100000)) -print_final_stats=1 -artifact_prefix="$build/findings/$target-" \
    >"$log" 2>&1; } 2>"$work/time" || failed=1
  cpu=$(tail -n 1 "$work/time" | awk '{ printf "%.1f", $1 + $2 }')
  echo "$target $cpu" >>"$build/cpu_seconds"
  findings=0
  if [ $failed = 1 ]; then
    # An input that was found before is written again. A slow input is no finding.
    while IFS= read -r input; do
      findings=$((findings + 1))
      echo "$target: FAILED on $input, see $log" >&2
    done < <(find "$build/findings" -name "$target-*" ! -name "$target-slow-unit-*" -newer "$work/begin")
    if [ $findings = 0 ]; then
      findings=1
      echo "$target: FAILED without an input, see $log" >&2
    fi
  fi
  all_findings=$((all_findings + findings))
  rows+=("$(printf '%-18s %12s %12s %9s %9s' "$target" "$(statistic number_of_executed_units "$log")" \
    "$(statistic new_units_added "$log")" "$findings" "$cpu")")
done
printf '%-18s %12s %12s %9s %9s\n' target runs "new inputs" findings "CPU s"
printf '%s\n' "${rows[@]}"
awk '{ sum += $2 } END { printf "CPU hours of all calls: %.2f\n", sum / 3600 }' "$build/cpu_seconds"
[ $all_findings = 0 ]
