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
  expect 1 "$pickbed" segment small.yaml --set sensor=none --out bad
  refused "belongs to a SCENARIO" "$pickbed" segment --clouds clouds --trials 3 --out bad
  refused "belongs to --clouds" "$pickbed" segment small.yaml --background-label 3 --out bad
  [ ! -e bad ] || fail "a refused command made its folder"
}

# Each bin draws its own objects. The results folder names them, so that all commands find them.
bins_draw_objects_from_a_pool() {
  cat >pool.yaml <<'YAML'
seed: 3
trials: 3
objects: [{name: sampled/machine/unseen_families/0-5, count: 1}]
draw: 2
YAML
  local run=("$pickbed" run pool.yaml --set planner.name=skirt --set policy.max_attempts=2 --pictures 0)
  expect 0 "${run[@]}" --jobs 1 --bop-out images --out pool_1
  grep -q "sampled/machine/unseen_families/5" pool_1/scenario.yaml || fail "no expanded list"
  expect 0 "${run[@]}" --jobs 2 --trials 2 --out pool_2
  expect 0 "${run[@]}" --jobs 2 --resume --out pool_2
  for file in attempts.csv instances.csv; do
    [ ! -e "pool_1/$file" ] || same "pool_1/$file" "pool_2/$file"
  done
  expect 0 "$pickbed" replay "pool_1#1"
  expect 0 "$pickbed" report pool_1
  expect 0 "$pickbed" dataset check images
  refused "draw = 9" "$pickbed" run pool.yaml --set draw=9 --out bad
  refused "write FIRST-LAST" "$pickbed" run pool.yaml --set objects.0.name=sampled/cup/5-x --out bad
  refused "check the pattern" "$pickbed" run pool.yaml --set objects.0.mesh='./*.none' \
    --set objects.0.mass_kg=1 --out bad
}

run_picks_on_true_shapes() {
  expect 0 "$pickbed" run small.yaml --trials 2 --set planner.name=completed \
    --set planner.completion=truth --pictures 0 --out picks
  [ "$(wc -l <picks/attempts.csv)" -gt 2 ] || fail "not one attempt in each of two trials"
  grep -qE "attempts that picked +[1-9]" last.out || fail "no attempt on true shapes picked"
  expect 1 "$pickbed" run small.yaml --set planner.name=completed --set planner.completion=magic \
    --out bad
  grep -q "planner.completion" last.err || fail "the setting is not named"
  refused "planner.success_model" "$pickbed" run small.yaml --set planner.name=completed \
    --set planner.success_model=magic --out bad
}
