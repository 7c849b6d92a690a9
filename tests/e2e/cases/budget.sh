# Cases of pickbed budget.

budget_shares_sum_for_any_number_of_jobs() {
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  cp -r one two
  expect 0 "$pickbed" budget one --jobs 1
  grep -q pose_wrong last.out || fail "no failure reason in the table"
  grep -q "^  everything" last.out || fail "no gain in the table"
  expect 0 "$pickbed" budget two --jobs 2 --json
  same last.out two/budget/budget.json
  for file in budget.json budget.csv attempts.png instances.png gains.png; do
    [ -s "one/budget/$file" ] || fail "no $file"
    same "one/budget/$file" "two/budget/$file"
  done
  for row in detection pose refinement grasp perception everything; do
    same "one/budget/$row/attempts.csv" "two/budget/$row/attempts.csv"
    same "one/budget/$row/instance_outcomes.csv" "two/budget/$row/instance_outcomes.csv"
  done
  # In each row and column: all = picked + not asked + failed.
  awk -F, 'NR > 1 { for (i = 4; i <= 5; ++i) sum[$1, i] += $3 == "all" ? $i : -$i; rows[$1] }
    END { for (row in rows) for (i = 4; i <= 5; ++i) if (sum[row, i] != 0) exit 1 }' \
    one/budget/budget.csv || fail "the shares do not sum to all"
  [ "$(grep -c ",all," one/budget/budget.csv)" = 7 ] || fail "not seven rows"
}

budget_resumes_after_an_interrupt() {
  # Enough bins that the command is still at work when the interrupt comes, at its first line.
  expect 0 "$pickbed" run small.yaml "${noisy[@]:0:4}" --trials 30 --pictures 0 --out here
  cp -r here whole
  "$pickbed" budget here --stages pose --jobs 1 2>stopped.err >/dev/null &
  local pid=$!
  for _ in $(seq 6000); do
    grep -q "pose (1/1)" stopped.err && break
    sleep 0.01
  done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "the exit status is not 130"
  grep -q "to continue" stopped.err || fail "no message how to continue"
  [ ! -e here/budget/budget.json ] || fail "an unfinished budget was written"
  expect 0 "$pickbed" budget here --stages pose
  expect 0 "$pickbed" budget whole --stages pose
  same here/budget/budget.json whole/budget/budget.json
}

invalid_budget_requests_are_refused() {
  refused "has no scenario.yaml" "$pickbed" budget nowhere
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out here
  refused "did you mean 'pose'?" "$pickbed" budget here --stages poes
  expect 0 "$pickbed" budget here --stages none
  [ ! -e here/budget/pose ] || fail "an unrequested rerun was made"
  # The results of others can name any program.
  cp -r here theirs
  sed -i '0,/^  name: .*oracle/s//  name: process/; 0,/^  command: \[\]/s//  command: [touch, started]/' \
    theirs/scenario.yaml
  refused "theirs: its settings use 'touch started'" "$pickbed" budget theirs --stages pose
  [ ! -e started ] || fail "a program of others was started"
  sed -i 's/^seed: .*/seed: 99/' here/scenario.yaml
  refused "repeat the run" "$pickbed" budget here
  rm here/results.sqlite
  refused "has no results.sqlite" "$pickbed" budget here
  refused "unknown policy.stop 'never'; known: until_empty, capture_again, one_pick" \
    "$pickbed" run small.yaml --set policy.stop=never --out no
  refused "unknown ranking 'best'; known: quality, epsilon, robust, tolerance, random" \
    "$pickbed" run small.yaml --set policy.ranking=best --out no
  refused "so it cannot decide a pick; choose right_instance or placed" \
    "$pickbed" run small.yaml --set policy.success=contact --out no
  [ ! -e no ] || fail "a refused run left a folder"
}
