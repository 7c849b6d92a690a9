# Cases of pickbed sweep and pickbed merge.

cat >sweep.yaml <<'YAML'
scenario: small.yaml
trials: 3
set: {estimator.name: oracle}
grid:
  estimator.noise_mm: [1, 9]
  objects.0.count: [2, 3]
YAML

sweep_results_do_not_depend_on_jobs_or_shards() {
  expect 0 "$pickbed" sweep sweep.yaml --jobs 1 --out one
  expect 0 "$pickbed" sweep sweep.yaml --jobs 2 --out two --json-progress
  grep -q '^{"what":"trial","done":12,"total":12,.*"success_ci95":\[' last.err || fail "no progress"
  grep -qv '^{' last.err && fail "not every line of progress is JSON"
  expect 0 "$pickbed" sweep sweep.yaml --jobs 2 --out two --resume
  grep -q "^results in two$" last.out || fail "the folder of the results is not named as given"
  for i in 2 3 1; do expect 0 "$pickbed" sweep sweep.yaml --shard $i/3 --jobs 2 --out parts; done
  expect 0 "$pickbed" merge parts/shards/* --out joined
  for file in trials.csv attempts.csv instance_outcomes.csv configurations.csv summary.json; do
    same "one/$file" "two/$file"
    same "one/$file" "joined/$file"
  done
  [ "$(wc -l <one/trials.csv)" = 13 ] || fail "not 12 trials"
  # A configuration gives the same results as a run of its file.
  expect 0 "$pickbed" run one/configurations/03_*.yaml --out point
  cut -d, -f5- point/attempts.csv >run.picks
  grep -E "^(trial|9|10|11)," one/attempts.csv | cut -d, -f5- >sweep.picks
  same run.picks sweep.picks
  # Different settings are merged side by side with --compare.
  expect 1 "$pickbed" merge one point --out both
  grep -q -- "--compare" last.err || fail "--compare is not suggested"
  expect 0 "$pickbed" merge one point --out both --compare
  [ "$(wc -l <both/configurations.csv)" = 6 ] || fail "not five configurations side by side"
}

a_killed_sweep_resumes() {
  "$pickbed" sweep sweep.yaml --trials 20 --jobs 2 --out long 2>stopped.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^trial [2-9]" stopped.err && break
    sleep 0.2
  done
  expect 1 "$pickbed" sweep sweep.yaml --trials 20 --out long --resume
  grep -q "in use by process $pid" last.err || fail "a second sweep in the folder was not refused"
  kill -KILL $pid
  wait $pid 2>/dev/null
  expect 0 "$pickbed" sweep sweep.yaml --trials 20 --jobs 2 --out long --resume
  expect 0 "$pickbed" sweep sweep.yaml --trials 20 --jobs 2 --out whole
  same long/trials.csv whole/trials.csv
  same long/attempts.csv whole/attempts.csv
}

sweep_stops_at_the_requested_interval_width() {
  local wide=(--trials 30 --set stop_width=0.9)
  expect 0 "$pickbed" sweep sweep.yaml "${wide[@]}" --jobs 1 --out one
  grep -q "estimator.noise_mm=1,objects.0.count=2: stops after [0-9]* bins" last.out || fail "the early stop is not reported"
  local bins=$(($(wc -l <one/trials.csv) - 1))
  [ "$bins" -ge 8 ] && [ "$bins" -lt 120 ] || fail "$bins bins"
  expect 0 "$pickbed" sweep sweep.yaml "${wide[@]}" --jobs 3 --out three
  for file in trials.csv attempts.csv configurations.csv summary.json; do same "one/$file" "three/$file"; done
  expect 1 "$pickbed" sweep sweep.yaml "${wide[@]}" --shard 1/2 --out parts
  grep -q "stop_width = 0.9: a shard does not have the scenes of the other shards" last.err || fail "a shard is not refused"
  [ ! -e parts ] || fail "a refused shard left a folder"
  expect 1 "$pickbed" run small.yaml --set stop_width=2 --out no
  grep -q "stop_width" last.err || fail "a width of 2 is not refused"
}

occlusion_sweep_uses_the_same_scenes_in_all_configurations() {
  cat >occlusion.yaml <<'YAML'
scenario: small.yaml
trials: 3
occlusion: {enabled: true, bands: [{min: 0.3, max: 0.6}, {min: 0.6, max: 0.9}, {min: 0.9, max: 1}]}
grid: {estimator.noise_mm: [0, 3]}
set: {estimator.name: oracle}
YAML
  expect 0 "$pickbed" sweep occlusion.yaml --jobs 1 --pictures 2 --out one
  expect 0 "$pickbed" sweep occlusion.yaml --jobs 2 --out two
  for file in trials.csv attempts.csv instance_outcomes.csv curve.csv summary.json; do same one/$file two/$file; done
  [ -s one/pictures/occlusion.png ] || fail "no picture of the series"
  [ "$(grep -c noise one/curve.csv)" = 6 ] || fail "not one line per configuration and band"
  # Counts are equal, and visible fractions do not depend on the configuration.
  [ "$(grep noise one/curve.csv | cut -d, -f4 | sort -u)" = 3 ] || fail "bands differ in their number of attempts"
  [ "$(grep noise one/curve.csv | cut -d, -f2-5 | sort -u | wc -l)" = 3 ] || fail "scenes differ"
  expect 1 "$pickbed" sweep occlusion.yaml --set occlusion.bands.1.min=0.5 --out bad
  grep -q "occlusion.bands.1.min = 0.5: must not be under bands.0.max = 0.6" last.err ||
    fail "overlapping bands are not refused"
  # A band that cannot be filled is named with its rejected blockers. The other bands keep their attempts.
  expect 0 "$pickbed" run small.yaml --set estimator.name=oracle --set occlusion.enabled=true \
    --set "occlusion.bands=[{min: 0.3, max: 0.3001}, {min: 0.9, max: 1}]" \
    --set occlusion.margin=0 --set occlusion.blocker_samples=2 --trials 2 --jobs 1 --out thin
  grep -q "30-30.01 %: trials without a scene: 2; rejected targets: .*; of .* blockers" last.out ||
    fail "a band without scenes is not named"
}

sweep_names_a_gripper_that_cannot_hold_the_object_once() {
  cat >two_grippers.yaml <<'YAML'
scenario: bin_rod
trials: 1
set: {estimator.name: oracle, objects.0.count: 1}
grid: {gripper: [jaw_4cm, [jaw_4cm, cup_30mm]], estimator.noise_mm: [0, 1]}
YAML
  expect 0 "$pickbed" sweep two_grippers.yaml --out two_grippers
  local line="gripper: cup_30mm cannot hold 'rod'; other grippers pick it"
  [ "$(grep -c "$line" last.err)" = 1 ] || fail "the gripper is not named once"
}

# _refused_sweep TEXT YAML: fails unless a sweep with this YAML is refused in one line with TEXT.
_refused_sweep() {
  local wanted=$1
  printf 'scenario: small.yaml\n%s\n' "$2" >bad.yaml
  expect 1 "$pickbed" sweep bad.yaml --out bad
  grep -q -- "$wanted" last.err || fail "no error with: $wanted"
  [ "$(wc -l <last.err)" = 1 ] || fail "more than one line"
}

invalid_sweeps_are_refused() {
  _refused_sweep "bad.yaml:2.*did you mean 'sensor'" "grid: {sensr: [ideal]}"
  _refused_sweep "bad.yaml:2.*the grid is empty" "grid: {}"
  _refused_sweep "bad.yaml:2.*gripper.*did you mean" "grid: {gripper: [jaw_9cm]}"
  _refused_sweep "has no grid" "trials: 3"
  expect 1 "$pickbed" sweep nothing.yaml
  expect 1 "$pickbed" sweep sweep.yaml --shard 4/3
  expect 1 "$pickbed" merge sweep.yaml --out joined
  refused "with --slurm, --cpus sets" "$pickbed" sweep sweep.yaml --slurm --jobs 4 --out here
  refused "--slurm submits all of them" "$pickbed" sweep sweep.yaml --slurm --shard 1/2 --out here
  expect 1 env PATH=/nowhere "$pickbed" sweep sweep.yaml --slurm --out here
  grep -q "there is no sbatch" last.err || fail "missing Slurm is not reported"
}
