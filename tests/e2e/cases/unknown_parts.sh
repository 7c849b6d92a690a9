# Cases of pickbed segment, and of picking without object models.

segment_scores_images_of_a_scenario() {
  expect 0 "$pickbed" segment small.yaml --trials 2 --method convexity --pictures 1 --out seg
  grep -q "weighted overlap" last.out || fail "no table"
  [ "$(wc -l <seg/segment_scores.csv)" = 3 ] || fail "not one line per image"
  [ "$(wc -l <seg/segments.csv)" -gt 3 ] || fail "no line per instance"
  [ -s seg/pictures/trial_0000.png ] || fail "no overlay"
  expect 0 "$pickbed" segment small.yaml --trials 2 --method convexity --pictures 0 --json --out again
  grep -q '"recall_50"' last.out || fail "no JSON"
  same seg/segments.csv again/segments.csv
}

segment_refuses_bad_input_in_one_line() {
  expect 1 "$pickbed" segment
  grep -q -- "--clouds" last.err || fail "no remedy"
  expect 1 "$pickbed" segment small.yaml --method convex --out bad
  grep -q convexity last.err || fail "no known names"
  mkdir clouds
  expect 1 "$pickbed" segment --clouds clouds --out bad
  grep -q "no \*.pcd" last.err || fail "an empty folder is not reported"
}

run_picks_on_true_shapes() {
  expect 0 "$pickbed" run small.yaml --trials 2 --set planner.name=completed \
    --set planner.completion=truth --pictures 0 --out picks
  [ "$(wc -l <picks/attempts.csv)" -gt 2 ] || fail "not one attempt in each of two trials"
  expect 1 "$pickbed" run small.yaml --set planner.name=completed --set planner.completion=magic \
    --out bad
  grep -q "planner.completion" last.err || fail "the setting is not named"
}
