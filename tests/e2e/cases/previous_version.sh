# Commands on results folders that the version before schema 6 wrote.

# Copies the folders, so that commands can write into them.
_copy_previous_version() { cp -r "$here/../data/previous_version" before && chmod -R u+w before; }

# Expects that the last command reported the former names of before/run in one line.
_reports_former_names() {
  [ "$(grep -c "^pickbed: before/run/scenario.yaml:18: 'foreign' is deprecated, write 'distractor'" last.err)" = 1 ] ||
    fail "not exactly one line about the former names of before/run"
}

previous_version_is_reported_and_compared() {
  _needs_report_page
  _copy_previous_version
  expect 0 "$pickbed" report before/run
  _reports_former_names
  page before/run/report.html "40.0 %"
  expect 0 "$pickbed" run before/run/scenario.yaml --pictures 0 --out now
  _reports_former_names
  expect 0 "$pickbed" compare before/run now --all
  _reports_former_names
  grep -q "^A is before/run, B is now; 2 scenes that both have" last.out || fail "the shared bins are not reported"
  grep -q "^  pick success, % *40.0 *40.0  +0.0 " last.out || fail "the picks of the same settings differ"
}

previous_version_budget_is_computed_and_resumed() {
  _copy_previous_version
  expect 0 "$pickbed" budget before/run --stages pose --json
  _reports_former_names
  grep -q '"before": 0.3333333333333333' last.out || fail "another share of successful attempts"
  mv last.out whole
  expect 0 "$pickbed" budget before/run --stages pose --json
  same last.out whole
  grep -q "trial" last.err && fail "the finished reruns were repeated"
  expect 0 "$pickbed" replay before/run/budget/pose#1
}

previous_version_trials_are_listed_and_replayed() {
  _copy_previous_version
  expect 0 "$pickbed" replay before/run#1 --list
  [ "$(wc -l <last.out)" = 3 ] || fail "not one line per trial"
  grep -qE "^ +1 +1 +3 +1  finished$" last.out || fail "another list of trial 1"
  [ ! -e before/run/replay ] || fail "a trial was replayed"
  # Scenes, images and hypotheses are the same. The planner has changed: it stores the tool, and it
  # rejects the candidates in another order.
  for trial in run#1 sweep#1 occlusion#0; do
    expect 1 "$pickbed" replay "before/$trial"
    grep -q "^first difference: attempt 0, stage grasp " last.out || fail "$trial differs elsewhere"
  done
}
