# Cases of pickbed run.

run_results_do_not_depend_on_jobs() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --jobs 1 --out one --pictures 0 --failure-pictures 0
  expect 0 "$pickbed" run small.yaml "${small[@]}" --jobs 2 --out two --pictures 1
  grep -q "^A bin of .* l gets 5 objects of .* l in all: .* % of its volume" last.out || fail "it does not say how full the bin is"
  same one/trials.csv two/trials.csv
  same one/attempts.csv two/attempts.csv
  same one/instances.csv two/instances.csv
  same one/summary.json two/summary.json
  [ -s one/summary.json ] || fail "summary.json is empty"
  [ "$(wc -l <one/trials.csv)" = 5 ] || fail "trials.csv does not have one line per trial"
  for rule in contact lifted held right_instance single_instance placed vgn_loose; do
    head -1 one/attempts.csv | grep -q ",$rule," || fail "attempts.csv has no column $rule"
    grep -q "\"$rule\": {" one/summary.json || fail "summary.json has no rate by $rule"
  done
  [ ! -e one/pictures ] || fail "unrequested pictures were written"
  for picture in color depth overlay after; do
    [ -s "two/pictures/trial_0000/attempt_00_$picture.png" ] || fail "no picture $picture"
  done
}

failed_picks_have_a_small_picture() {
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --jobs 1 --out one
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --jobs 2 --out two
  local lost=$(awk -F, 'NR > 1 { for (i = 1; i <= NF; ++i) if ($i == "pose_wrong") ++n } END { print n + 0 }' one/attempts.csv)
  [ "$lost" -ge 1 ] || fail "no pick failed"
  local shown=$(find one/pictures -name "attempt_*_failed.jpg" | wc -l)
  [ "$shown" -ge "$lost" ] || fail "$shown pictures of $lost failed picks"
  [ "$(find one/pictures -type f | wc -l)" = "$shown" ] || fail "unrequested pictures were written"
  diff -r one/pictures two/pictures >&2 || fail "pictures depend on the number of workers"
}

distractors_do_not_count() {
  cat >distractor.yaml <<'YAML'
trials: 1
objects:
  - {name: flange, count: 2, distractor: true}
  - {name: rod, count: 3}
YAML
  expect 0 "$pickbed" run distractor.yaml "${small[@]}" --out one --pictures 0
  grep -q "^0,0,0,finished,3," one/trials.csv || fail "distractors count as dropped instances"
  expect 1 "$pickbed" run distractor.yaml --set objects.1.distractor=true --out two
  grep -q "all objects are distractors" last.err || fail "a scenario with only distractors is not refused"
}

another_seed_gives_other_results() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out one
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out two --set seed=8
  cmp -s one/attempts.csv two/attempts.csv && fail "seeds 7 and 8 gave the same picks"
  return 0
}

stdout_has_only_json() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --json --out json
  same last.out json/summary.json
}

run_resumes_after_an_interrupt() {
  "$pickbed" run small.yaml "${small[@]}" --trials 200 --jobs 2 --out long 2>stopped.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^trial [2-9]" stopped.err && break
    sleep 0.2
  done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "the exit status is not 130"
  grep -q -- "--resume" stopped.err || fail "--resume is not suggested"
  local kept=$(($(wc -l <long/trials.csv) - 1))
  [ "$kept" -ge 1 ] && [ "$kept" -lt 200 ] || fail "$kept trials were kept"
  expect 1 "$pickbed" run small.yaml "${small[@]}" --trials 200 --out long
  grep -q -- "--resume" last.err || fail "a folder with results is not reported"

  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials $((kept + 2)) --out long --resume
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials $((kept + 2)) --out whole
  same long/trials.csv whole/trials.csv
  same long/attempts.csv whole/attempts.csv
}

a_killed_worker_loses_nothing() {
  "$pickbed" run small.yaml "${small[@]}" --trials 12 --jobs 2 --out killed 2>killed.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^trial [2-9]" killed.err && break
    sleep 0.2
  done
  kill -KILL "$(ps -o pid= --ppid $pid | tail -1)"
  wait $pid
  [ $? = 0 ] || fail "the exit status is not 0"
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 12 --out whole
  same killed/trials.csv whole/trials.csv
  same killed/attempts.csv whole/attempts.csv
}

a_full_disk_keeps_finished_trials() {
  (
    trap '' XFSZ # a write beyond the limit then fails and does not kill
    ulimit -f 200
    "$pickbed" run small.yaml "${small[@]}" --trials 100 --out full --pictures 0 2>full.err
  )
  [ $? = 1 ] || fail "the exit status is not 1"
  grep -q "results.sqlite" full.err || fail "the file is not named"
  expect 1 "$pickbed" run small.yaml "${small[@]}" --trials 100 --out full
  grep -q "finished trials" last.err || fail "no trial was kept"
}

resume_with_other_settings_is_refused() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out here
  expect 1 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out here --resume --set seed=9
  grep -q "other settings (seed: .* before, 9 now)" last.err || fail "the other setting is not named"
  [ "$(wc -l <last.err)" = 1 ] || fail "more than one line"
}

written_scenario_reproduces_the_run() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out first
  expect 0 "$pickbed" run first/scenario.yaml --out second
  same first/attempts.csv second/attempts.csv
}
