# Cases of faults around a run. tests/faults has kills and full disks at seeded moments.

# Kills each worker that starts, as the kernel does at a memory limit.
workers_killed_for_memory_are_reported_as_such() {
  "$pickbed" run small.yaml "${small[@]}" --trials 1 --jobs 1 --pictures 0 --out killed 2>killed.err >/dev/null &
  local pid=$!
  while kill -0 $pid 2>/dev/null; do
    pkill -KILL -P $pid
    sleep 0.05
  done
  wait $pid
  [ $? = 1 ] || fail "the exit status is not 1"
  [ "$(grep -c '^pickbed: ' killed.err)" = 1 ] || fail "not exactly one error line"
  grep -q "killed (signal 9), often because the memory limit was reached; use fewer workers (--jobs)" killed.err ||
    fail "memory is not suggested"
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out killed --resume --retry-crashed --pictures 0
}

# A shared folder that disappears, and comes back.
a_lost_results_folder_is_named_and_can_be_resumed() {
  "$pickbed" run small.yaml "${small[@]}" --trials 60 --jobs 2 --pictures 0 --out here 2>lost.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^trial [2-9]" lost.err && break
    sleep 0.1
  done
  mv here away
  wait $pid
  [ $? = 1 ] || fail "the exit status is not 1"
  [ "$(grep -c '^pickbed: ' lost.err)" = 1 ] || fail "not exactly one error line"
  grep -q "here/.* gone, because its folder was removed, was renamed or cannot be reached" lost.err ||
    fail "the lost folder is not named"
  rm -rf here
  mv away here
  local kept=$(echo 'import sqlite3; print(sqlite3.connect("here/results.sqlite").execute("select count(*) from trials").fetchone()[0])' | python3)
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials $((kept + 1)) --pictures 0 --out here --resume
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials $((kept + 1)) --pictures 0 --out whole
  same here/trials.csv whole/trials.csv
  same here/attempts.csv whole/attempts.csv
}

# _read_only COMMAND...: runs a command with the folder "there" mounted read-only.
_read_only() {
  unshare --mount $([ "$(id -u)" = 0 ] || echo --map-root-user) \
    sh -c 'mount --bind there there && mount -o remount,bind,ro there && exec "$@"' sh "$@"
}

a_read_only_folder_is_refused_in_one_line() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --pictures 0 --out there
  _read_only true 2>/dev/null || exit 77
  for arguments in "run small.yaml --out there" "run small.yaml --out there --resume" "run small.yaml --out there/new" \
    "merge there --out there/merged" "report there"; do
    if [ "$arguments" = "report there" ] && ! has_template; then continue; fi
    expect 1 _read_only "$pickbed" $arguments
    [ "$(grep -c '^pickbed: ' last.err)" = 1 ] || fail "not exactly one error line: $arguments"
    grep '^pickbed: ' last.err | grep -q "there" || fail "the folder is not named: $arguments"
  done
  expect 0 _read_only "$pickbed" merge there --out elsewhere
}
