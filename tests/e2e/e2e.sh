#!/bin/bash
# End-to-end checks of the program as a user runs it.
#   e2e.sh PICKBED CASE
# CASE is the name of a function below; each works in a folder of its own and fails loudly.
set -u
here=$(cd "$(dirname "$0")" && pwd)
pickbed=$1
name=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/pickbed_e2e_XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1

fail() {
  echo "FAIL ($name): $*" >&2
  for log in "$work"/*.err; do [ -f "$log" ] && sed "s|^|  $(basename "$log"): |" "$log" >&2; done
  exit 1
}

# expect STATUS COMMAND... : runs it with stdout in last.out and stderr in last.err.
expect() {
  local wanted=$1
  shift
  "$@" >last.out 2>last.err
  local status=$?
  [ "$status" = "$wanted" ] || fail "exit $status, expected $wanted, of: $*"
}
same() { cmp -s "$1" "$2" || fail "$1 and $2 differ"; }

# A small bin of convex parts with true poses, quick and without a network.
small=(--set estimator.name=oracle --set estimator.noise_mm=1)
cat >small.yaml <<'YAML'
seed: 7
trials: 4
objects:
  - {name: rod, count: 3}
  - {name: flange, count: 2}
YAML
echo "objects: [{name: rod, count: 3}]" >rods.yaml

jobs_do_not_matter() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --jobs 1 --out one --pictures 0
  expect 0 "$pickbed" run small.yaml "${small[@]}" --jobs 2 --out two --pictures 1
  same one/trials.csv two/trials.csv
  same one/picks.csv two/picks.csv
  same one/summary.json two/summary.json
  [ -s one/summary.json ] || fail "summary.json is empty"
  [ "$(wc -l <one/trials.csv)" = 5 ] || fail "trials.csv has not one line a trial"
  for rule in contact lifted held right_part single_part placed vgn_loose; do
    head -1 one/picks.csv | grep -q ",$rule," || fail "picks.csv has no column $rule"
    grep -q "\"$rule\": {" one/summary.json || fail "summary.json has no rate by $rule"
  done
  [ ! -e one/pictures ] || fail "pictures were not wanted"
  for picture in color depth overlay after; do
    [ -s "two/pictures/trial_0000/pick_00_$picture.png" ] || fail "no picture $picture"
  done
}

foreign_parts_are_not_wanted() {
  cat >foreign.yaml <<'YAML'
trials: 1
objects:
  - {name: flange, count: 2, foreign: true}
  - {name: rod, count: 3}
YAML
  expect 0 "$pickbed" run foreign.yaml "${small[@]}" --out one --pictures 0
  grep -q "^0,0,0,finished,3," one/trials.csv || fail "foreign parts count as dropped ones"
  expect 1 "$pickbed" run foreign.yaml --set objects.1.foreign=true --out two
  grep -q "all parts are foreign" last.err || fail "nothing is wanted, and it runs"
}

another_seed_gives_other_results() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out one
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out two --set seed=8
  cmp -s one/picks.csv two/picks.csv && fail "seeds 7 and 8 gave the same picks"
  return 0
}

json_alone_on_stdout() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --json --out json
  same last.out json/summary.json
}

interrupt_and_resume() {
  "$pickbed" run small.yaml "${small[@]}" --trials 200 --jobs 2 --out long 2>stopped.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^trial [2-9]" stopped.err && break
    sleep 0.2
  done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "exit was not 130"
  grep -q -- "--resume" stopped.err || fail "--resume was not offered"
  local kept=$(($(wc -l <long/trials.csv) - 1))
  [ "$kept" -ge 1 ] && [ "$kept" -lt 200 ] || fail "$kept trials were kept"
  expect 1 "$pickbed" run small.yaml "${small[@]}" --trials 200 --out long
  grep -q -- "--resume" last.err || fail "a folder with results was not explained"

  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials $((kept + 2)) --out long --resume
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials $((kept + 2)) --out whole
  same long/trials.csv whole/trials.csv
  same long/picks.csv whole/picks.csv
}

other_commands_stop_at_once() {
  "$pickbed" estimate small.yaml "${small[@]}" --trials 500 --out look 2>stopped.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^bin" stopped.err && break
    sleep 0.2
  done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "exit was not 130"
  grep -q "interrupted" stopped.err || fail "nothing was said"
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
  [ $? = 0 ] || fail "exit was not 0"
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 12 --out whole
  same killed/trials.csv whole/trials.csv
  same killed/picks.csv whole/picks.csv
}

cat >sweep.yaml <<'YAML'
scenario: small.yaml
trials: 3
set: {estimator.name: oracle}
grid:
  estimator.noise_mm: [1, 9]
  objects.0.count: [2, 3]
YAML

a_sweep_is_the_same_by_shards() {
  expect 0 "$pickbed" sweep sweep.yaml --jobs 1 --out one
  expect 0 "$pickbed" sweep sweep.yaml --jobs 2 --out two --json-progress
  grep -q '^{"what":"trial","done":12,"total":12,.*"success_ci95":\[' last.err || fail "no progress"
  grep -qv '^{' last.err && fail "not every line of progress is JSON"
  for i in 2 3 1; do expect 0 "$pickbed" sweep sweep.yaml --shard $i/3 --jobs 2 --out parts; done
  expect 0 "$pickbed" merge parts/shards/* --out joined
  for file in trials.csv picks.csv parts.csv points.csv summary.json; do
    same "one/$file" "two/$file"
    same "one/$file" "joined/$file"
  done
  [ "$(wc -l <one/trials.csv)" = 13 ] || fail "not 12 trials"
  # A point is the run that its file says.
  expect 0 "$pickbed" run one/points/03_*.yaml --out point
  cut -d, -f5- point/picks.csv >run.picks
  grep -E "^(trial|9|10|11)," one/picks.csv | cut -d, -f5- >sweep.picks
  same run.picks sweep.picks
  # Unlike settings stand side by side when they are asked to.
  expect 1 "$pickbed" merge one point --out both
  grep -q -- "--compare" last.err || fail "--compare was not offered"
  expect 0 "$pickbed" merge one point --out both --compare
  [ "$(wc -l <both/points.csv)" = 6 ] || fail "not five points side by side"
}

a_sweep_stops_and_goes_on() {
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
  same long/picks.csv whole/picks.csv
}

an_occlusion_sweep_sees_the_same_scenes_at_all_points() {
  cat >occlusion.yaml <<'YAML'
scenario: small.yaml
trials: 3
occlusion: {enabled: true, bands: [{least: 0.3, most: 0.6}, {least: 0.6, most: 0.9}, {least: 0.9, most: 1}]}
grid: {estimator.noise_mm: [0, 3]}
set: {estimator.name: oracle}
YAML
  expect 0 "$pickbed" sweep occlusion.yaml --jobs 1 --pictures 2 --out one
  expect 0 "$pickbed" sweep occlusion.yaml --jobs 2 --out two
  for file in trials.csv picks.csv parts.csv curve.csv summary.json; do same one/$file two/$file; done
  [ -s one/pictures/occlusion.png ] || fail "no picture of the series"
  [ "$(grep -c noise one/curve.csv)" = 6 ] || fail "not a line a point and band"
  # Equal counts, and visible fractions that do not depend on the point.
  [ "$(grep noise one/curve.csv | cut -d, -f4 | sort -u)" = 3 ] || fail "bands differ in looks"
  [ "$(grep noise one/curve.csv | cut -d, -f2-5 | sort -u | wc -l)" = 3 ] || fail "scenes differ"
  expect 1 "$pickbed" sweep occlusion.yaml --set occlusion.bands.1.least=0.5 --out bad
  grep -q "occlusion.bands.1.least = 0.5: must not be under bands.0.most = 0.6" last.err ||
    fail "bands that overlap are not told"
  # A band that nothing fills is named, with what was tried, and the others have their looks.
  expect 0 "$pickbed" run small.yaml --set estimator.name=oracle --set occlusion.enabled=true \
    --set "occlusion.bands=[{least: 0.3, most: 0.3001}, {least: 0.9, most: 1}]" \
    --set occlusion.margin=0 --set occlusion.tries=2 --trials 2 --jobs 1 --out thin
  grep -q "30-30.01 %: 2 trials without a scene; .* targets given up; of .* blockers" last.out ||
    fail "a band without scenes is not named"
}

# refused_sweep TEXT YAML-LINE...: a sweep with this grid ends with one line that says TEXT.
refused_sweep() {
  local wanted=$1
  printf 'scenario: small.yaml\n%s\n' "$2" >bad.yaml
  expect 1 "$pickbed" sweep bad.yaml --out bad
  grep -q -- "$wanted" last.err || fail "not told: $wanted"
  [ "$(wc -l <last.err)" = 1 ] || fail "more than one line"
}

bad_sweeps_are_refused() {
  refused_sweep "bad.yaml:2.*did you mean 'sensor'" "grid: {sensr: [ideal]}"
  refused_sweep "bad.yaml:2.*the grid is empty" "grid: {}"
  refused_sweep "bad.yaml:2.*gripper.*did you mean" "grid: {gripper: [jaw_9cm]}"
  refused_sweep "has no grid" "trials: 3"
  expect 1 "$pickbed" sweep nothing.yaml
  expect 1 "$pickbed" sweep sweep.yaml --shard 4/3
  expect 1 "$pickbed" merge sweep.yaml --out joined
  expect 1 env PATH=/nowhere "$pickbed" sweep sweep.yaml --slurm --out here
  grep -q "there is no sbatch" last.err || fail "that Slurm is absent is not told"
}

truncated_model_is_refused() {
  local model=$here/../../assets/models/shipped.pt
  head -c 5000 "$model" >cut.pt
  expect 1 "$pickbed" estimate small.yaml --set "estimator.model=$work/cut.pt" --out cut
  grep -q "cut.pt" last.err || fail "the file is not named"
  [ "$(wc -l <last.err)" = 1 ] || fail "more than one line"
}

a_full_disk_keeps_finished_trials() {
  (
    trap '' XFSZ # a write beyond the limit then fails instead of killing
    ulimit -f 200
    "$pickbed" run small.yaml "${small[@]}" --trials 100 --out full --pictures 0 2>full.err
  )
  [ $? = 1 ] || fail "exit was not 1"
  grep -q "results.sqlite" full.err || fail "the file is not named"
  expect 1 "$pickbed" run small.yaml "${small[@]}" --trials 100 --out full
  grep -q "finished trials" last.err || fail "no trial was kept"
}

other_settings_are_refused() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out here
  expect 1 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out here --resume --set seed=9
  grep -q "other settings" last.err || fail "not explained"
  [ "$(wc -l <last.err)" = 1 ] || fail "more than one line"
}

written_scenario_runs_again() {
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --out first
  expect 0 "$pickbed" run first/scenario.yaml --out second
  same first/picks.csv second/picks.csv
}

# A run whose poses are so wrong that picks are lost to them.
noisy=(--set estimator.name=oracle --set estimator.noise_mm=9 --trials 2 --pictures 0)

budget_sums_and_jobs_do_not_matter() {
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  cp -r one two
  expect 0 "$pickbed" budget one --jobs 1
  grep -q pose_wrong last.out || fail "no loss in the table"
  grep -q "^  everything" last.out || fail "no gain in the table"
  expect 0 "$pickbed" budget two --jobs 2 --json
  same last.out two/budget/budget.json
  for file in budget.json budget.csv attempts.png instances.png gains.png; do
    [ -s "one/budget/$file" ] || fail "no $file"
    same "one/budget/$file" "two/budget/$file"
  done
  for row in detection pose refinement grasp perception everything; do
    same "one/budget/$row/picks.csv" "two/budget/$row/picks.csv"
    same "one/budget/$row/parts.csv" "two/budget/$row/parts.csv"
  done
  # Of each row and column, all = picked + not asked + lost.
  awk -F, 'NR > 1 { for (i = 4; i <= 5; ++i) sum[$1, i] += $3 == "all" ? $i : -$i; rows[$1] }
    END { for (row in rows) for (i = 4; i <= 5; ++i) if (sum[row, i] != 0) exit 1 }' \
    one/budget/budget.csv || fail "the parts do not sum to all"
  [ "$(grep -c ",all," one/budget/budget.csv)" = 7 ] || fail "not seven rows"
}

budget_stops_and_goes_on() {
  # Enough bins for it to be at work when it is told to stop, at its first line.
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
  [ $? = 130 ] || fail "exit was not 130"
  grep -q "goes on" stopped.err || fail "nothing was said"
  [ ! -e here/budget/budget.json ] || fail "half a budget was written"
  expect 0 "$pickbed" budget here --stages pose
  expect 0 "$pickbed" budget whole --stages pose
  same here/budget/budget.json whole/budget/budget.json
}

bad_budgets_are_refused() {
  refused "holds no scenario.yaml" "$pickbed" budget nowhere
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out here
  refused "did you mean 'pose'?" "$pickbed" budget here --stages poes
  expect 0 "$pickbed" budget here --stages none
  [ ! -e here/budget/pose ] || fail "a rerun was not wanted"
  sed -i 's/^seed: .*/seed: 99/' here/scenario.yaml
  refused "repeat the run" "$pickbed" budget here
  rm here/results.sqlite
  refused "holds no results.sqlite" "$pickbed" budget here
  refused "unknown policy.stop 'never'; known: until_empty, look_again, one_pick" \
    "$pickbed" run small.yaml --set policy.stop=never --out no
  refused "unknown ranking 'best'; known: quality, epsilon, robust, random" \
    "$pickbed" run small.yaml --set policy.ranking=best --out no
  refused "so it cannot decide a pick; choose right_part or placed" \
    "$pickbed" run small.yaml --set policy.success=contact --out no
  [ ! -e no ] || fail "a refused run left a folder"
}

a_replay_is_the_same() {
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  expect 0 "$pickbed" replay one#1
  grep -q "^all that is recorded is the same" last.out || fail "it is not said that all is the same"
  [ "$(grep -c " same$" last.out)" -ge 5 ] || fail "not all stages of a look are named"
  for file in color.png depth.png ids.png overlay.png after.png cloud.ply hypotheses.ply scene.glb; do
    [ -s "one/replay/trial_0001/look_00_$file" ] || fail "no $file"
  done
  # From another place, and a trial that was fed with truth.
  expect 0 "$pickbed" budget one --stages pose
  cd / || fail "cannot go elsewhere"
  "$pickbed" replay "$work/one#0" --out "$work/elsewhere" >"$work/last.out" || fail "not the same elsewhere"
  [ -s "$work/elsewhere/stages.csv" ] || fail "no stages.csv"
  "$pickbed" replay "$work/one/budget/pose#1" >"$work/last.out" 2>"$work/last.err" ||
    fail "a rerun of the budget is not the same"
  [ "$(grep -c " same$" "$work/last.out")" -ge 5 ] || fail "not all stages of the rerun are named"
}

a_replay_names_what_changed() {
  cp "$here/../../assets/grippers/jaw_8cm.yaml" jaw.yaml
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --set gripper=jaw.yaml --out one
  sed -i 's/^clearance_m: .*/clearance_m: 0.006/' jaw.yaml
  expect 1 "$pickbed" replay one#1
  grep -q "^changed since the trial ran: was 'clearance_m: 0.003', is 'clearance_m: 0.006'" last.out ||
    fail "the changed file is not told"
  grep -q "^first difference: look 0, stage grasp" last.out || fail "the stage is not named"
}

bad_replays_are_refused() {
  refused "one: which trial? name it as RUN#TRIAL, for instance one#0" "$pickbed" replay one
  refused "there is no folder nowhere" "$pickbed" replay nowhere#1
  mkdir empty
  refused "empty holds no results.sqlite" "$pickbed" replay empty#1
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  refused "one#7: the run has no such trial" "$pickbed" replay one#7
  refused "one#x: 'x' is no number of a trial" "$pickbed" replay one#x
  head -c 5000 one/results.sqlite >cut && mv cut one/results.sqlite
  refused "results.sqlite" "$pickbed" replay one#1
}

# Without npm's registry the program is built without the page of its reports, and says so.
needs_report_page() {
  [ -s "$(dirname "$pickbed")/report/page.html" ] ||
    { echo "skipped: the page of reports was not built, see the build's output"; exit 77; }
}

# browser PAGE VIEWS: the page works in Chromium and has that many 3D views.
browser() {
  node "$here/report_check.mjs" "$1" --views "$2" >browser.out 2>browser.err ||
    fail "$1 does not work in a browser"
  [ "$(stat -c %s "$1")" -lt 15000000 ] || fail "$1 is too large"
}

reports_work_in_a_browser() {
  needs_report_page
  local one=(--set policy.stop=one_pick --trials 12 --set estimator.name=oracle)
  expect 0 "$pickbed" run small.yaml "${one[@]}" --set estimator.noise_mm=9 --pictures 12 --out one
  expect 0 "$pickbed" run small.yaml "${one[@]}" --set estimator.noise_mm=3 --out two
  expect 0 "$pickbed" report one
  grep -q "one/report.html" last.out || fail "the page is not named"
  browser one/report.html 2
  grep -q "data:image/jpeg" one/report.html || fail "no picture of a lost pick"
  expect 0 "$pickbed" report one --out again.html
  same one/report.html again.html
  expect 0 "$pickbed" compare one two --out both.html
  browser both.html 2
  expect 0 "$pickbed" report two --views 0 --out flat.html
  browser flat.html 0
  [ "$(stat -c %s flat.html)" -lt 1200000 ] || fail "a page without 3D views holds their library"
}

bad_reports_are_refused() {
  needs_report_page
  refused "nowhere" "$pickbed" report nowhere
  mkdir empty
  refused "empty" "$pickbed" report empty
  echo "no database" >empty/results.sqlite
  refused "results.sqlite" "$pickbed" report empty
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --pictures 0 --out one
  refused "is a folder" "$pickbed" report one --out .
  refused "named twice" "$pickbed" compare one one --out both.html
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --pictures 0 --set seed=8 --out other
  refused "seed" "$pickbed" compare one other --out both.html
  [ ! -e both.html ] || fail "a refused comparison left a page"
  [ ! -e one/report.html ] || fail "a refused report left a page"
}

drop_and_render_write_their_files() {
  expect 0 "$pickbed" drop small.yaml --out drop
  [ "$(grep -c '"instance"' drop/scene.json)" = 5 ] || fail "scene.json does not hold 5 parts"
  [ -s drop/color.png ] || fail "no picture"
  expect 0 "$pickbed" render small.yaml --out render
  for file in color.png depth.png depth_color.png ids.png ids_color.png visible.csv; do
    [ -s "render/$file" ] || fail "no $file"
  done
  [ "$(wc -l <render/visible.csv)" = 6 ] || fail "visible.csv does not hold 5 parts"
}

estimate_scores_the_oracle_as_perfect() {
  expect 0 "$pickbed" estimate small.yaml --set estimator.name=oracle --trials 2 --out look
  head -1 look/hypotheses.csv | grep -q 'correct,p_pick$' || fail "other columns than expected"
  local wrong=$(tail -n +2 look/hypotheses.csv | grep -vc ',1,$')
  [ "$wrong" = 0 ] || fail "$wrong true poses were called wrong"
  [ "$(wc -l <look/hypotheses.csv)" -gt 5 ] || fail "too few hypotheses"
  [ -s look/pictures/trial_0001/oracle/pick_00_overlay.png ] || fail "no overlay"
}

# shown FOLDER: its page names pictures, and all of them are there.
shown() {
  local pictures=$(grep -o 'src="[^"]*"' "$1/explain.html" | cut -d'"' -f2)
  [ "$(wc -w <<<"$pictures")" -ge 9 ] || fail "too few pictures in $1"
  for picture in $pictures; do [ -s "$1/$picture" ] || fail "no $1/$picture"; done
  [ "$(wc -w <<<"$pictures")" = "$(find "$1/pictures" -type f | wc -l)" ] ||
    fail "a picture in $1 is not shown"
}

explain_shows_every_stage() {
  expect 0 "$pickbed" estimate rods.yaml --explain 1 --out why
  grep -q "why/explain.html" last.out || fail "the page is not named"
  shown why
  for stage in 1 2 3 4 5 6 7 8; do grep -q "<h2>$stage\\." why/explain.html || fail "no stage $stage"; done
  expect 0 "$pickbed" estimate rods.yaml --explain 1 --out again
  diff -r why again >&2 || fail "the same image was explained in another way"

  echo "camera: {width: 160, height: 120, focal_px: 170}" >>rods.yaml
  expect 0 "$pickbed" dataset make rods.yaml --scenes 1 --views 2 --jobs 1 --out set
  expect 0 "$pickbed" estimate --bop set --explain 1/1 --out bop
  shown bop
  expect 0 "$pickbed" estimate --bop set --explain 1 --out same
  diff -r bop same >&2 || fail "1/1 is not the second target"
  refused "--explain 7/0: is no target image; name one as SCENE/IMAGE, such as 1/0" \
    "$pickbed" estimate --bop set --explain 7/0 --out no
  refused "'ppf' does not tell" "$pickbed" estimate --bop set --explain 0 --estimator ppf --out no
  [ ! -e no ] || fail "a refused command left a folder"
}

broken_model_is_refused() {
  head -c 1000 /dev/urandom >broken.pt
  expect 1 "$pickbed" run small.yaml --set estimator.name=descriptor \
    --set "estimator.model=$work/broken.pt" --out broken
  grep -q "broken.pt" last.err || fail "the file is not named"
  expect 1 "$pickbed" run small.yaml --set estimator.name=descriptor \
    --set "estimator.model=$work/missing.pt" --out missing
  grep -q "missing.pt" last.err || fail "the file is not named"
}

train_stops_and_resumes() {
  local quick=(--set piles=2 --set iterations=80 --set checkpoint_every=5 --set held_out.piles=1
    --set held_out.book_views=50 --set held_out.every=20
    --set verifier_piles=2 --set verifier_entries=2000 --set verifier.iterations=100)
  local short=(rod "${quick[@]}")
  "$pickbed" train "${short[@]}" --out rod.pt 2>stopped.err &
  local pid=$!
  while kill -0 $pid 2>/dev/null && ! grep -q "^network" stopped.err; do sleep 0.1; done
  kill -INT $pid 2>/dev/null
  wait $pid
  local rc=$?
  [ $rc = 130 ] || fail "exit was $rc and not 130"
  [ -s rod.pt.checkpoint ] || fail "no checkpoint"
  [ ! -e rod.pt ] || fail "an unfinished model was written"
  cp rod.pt.checkpoint good.checkpoint
  (
    trap '' XFSZ # a write beyond the limit then fails instead of killing
    ulimit -f 100
    "$pickbed" train "${short[@]}" --out rod.pt --resume 2>last.err
  )
  [ $? = 1 ] || fail "a full disk did not end the training"
  grep -q "^pickbed: .*rod.pt.checkpoint" last.err || fail "the checkpoint on a full disk is not named"
  same rod.pt.checkpoint good.checkpoint
  expect 0 "$pickbed" train "${short[@]}" --out rod.pt --resume
  for file in index.html embedding.png answers.png pairs.png curves.csv timings.csv; do
    [ -s "rod_report/$file" ] || fail "no $file in the report"
  done
  expect 0 "$pickbed" train "${short[@]}" --out unstopped.pt
  cmp rod.pt unstopped.pt || fail "a stopped and resumed training gives other weights"
  same rod_report/curves.csv unstopped_report/curves.csv
  expect 0 "$pickbed" estimate rods.yaml --out look --set "estimator.model=$work/rod.pt"
  refused "rod.pt: not trained for part 'flange' (knows rod)" \
    "$pickbed" estimate small.yaml --out look --set "estimator.model=$work/rod.pt"

  # Another part beside the one that is known.
  expect 0 "$pickbed" train flange --from rod.pt "${quick[@]}" --out both.pt --report page \
    --sensor structured_light,time_of_flight
  grep -q "structured_light, time_of_flight" page/index.html || fail "the sensors are not named"
  grep -q "rod, known before: recall@1" last.out || fail "nothing is said of the part known before"
  [ -s page/index.html ] || fail "no report where it was asked for"
  [ ! -e both.pt.checkpoint ] || fail "the checkpoint of a finished training is left over"
  expect 0 "$pickbed" estimate small.yaml --out look --set "estimator.model=$work/both.pt"

  # The same name, another mesh.
  brick 1 >brick.obj
  expect 0 "$pickbed" object add brick.obj --name rod --mass 0.1 --drops 5
  refused "rod.pt: the mesh of part 'rod' has changed since training" \
    "$pickbed" estimate rods.yaml --out look --set "estimator.model=$work/rod.pt"
  refused "rod.pt: the mesh of part 'rod' has changed since training; name the part" \
    "$pickbed" train flange --from rod.pt "${quick[@]}" --out both.pt
}

bad_training_is_refused() {
  refused "nothing to learn" "$pickbed" train
  refused "missing.pt: there is no such trained model" "$pickbed" train rod --from missing.pt
  head -c 1000 /dev/urandom >broken.pt
  refused "broken.pt" "$pickbed" train rod --from broken.pt
  refused "did you mean 'rod'" "$pickbed" train rodd
  refused "unknown sensor 'sonar'" "$pickbed" train rod --sensor sonar
  refused "no checkpoint" "$pickbed" train rod --out new.pt --resume
  refused "PICKBED_DEVICE is 'gpu'" env PICKBED_DEVICE=gpu "$pickbed" train rod --out new.pt
  brick 1 | awk '/^v/ {print "v", $2 / 10, $3 / 10, $4 / 10; next} {print}' >speck.obj
  echo "objects: [{name: speck, mesh: speck.obj, unit: mm, mass_kg: 0.01, count: 3}]" >specks.yaml
  refused "part 'speck' is" "$pickbed" train --scenario specks.yaml --out specks.pt
  grep -q "10 px are the least" last.err || fail "the least size is not said"
  grep -q "^views" last.err && fail "it was said only after views were rendered"
  echo "objects: []" >none.yaml
  refused "none.yaml" "$pickbed" train --scenario none.yaml
}

grippers_are_drawn() {
  for gripper in jaw_4cm jaw_8cm jaw_14cm cup_30mm; do
    expect 0 "$pickbed" gripper show "$gripper"
    [ -s "results/gripper_$gripper.png" ] || fail "no picture of $gripper"
  done
  grep -q "vacuum_n: 45" last.out || fail "the cup's force is not told"
  printf 'mechanism: suction_cup\nvacuum_n: 0\n' >weak.yaml
  expect 1 "$pickbed" gripper show weak.yaml
  grep -q "weak.yaml:2: vacuum_n = 0" last.err || fail "a cup without force is not refused"
}

an_added_object_is_dropped() {
  cat >brick.obj <<'OBJ'
v -30 -20 -10
v 30 -20 -10
v -30 20 -10
v 30 20 -10
v -30 -20 10
v 30 -20 10
v -30 20 10
v 30 20 10
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
OBJ
  expect 0 "$pickbed" object add brick.obj --name brick --mass 0.05
  grep -q "unit guessed: mm" last.out || fail "the unit was not guessed"
  for file in mesh.obj convex.obj object.yaml made.json sheet.png; do
    [ -s "objects/brick/$file" ] || fail "no $file"
  done
  expect 0 "$pickbed" object add brick.obj --name brick --mass 0.05
  grep -q "nothing to do" last.out || fail "it was made twice"
  refused "--name ''" "$pickbed" object add brick.obj --name ''
  refused "is no file" "$pickbed" object add /dev/zero --name zero
  refused "--mass nan" "$pickbed" object add brick.obj --name heavy --mass nan
  expect 1 "$pickbed" object add brick.obj --name brick --mass 0.06
  grep -q -- "--replace" last.err || fail "an existing part was not explained"
  echo "objects: [{name: brick, count: 4}]" >bricks.yaml
  expect 0 "$pickbed" run bricks.yaml "${small[@]}" --trials 1 --out bricks
  grep -q '"parts_cleared": 4' bricks/summary.json || fail "the bricks were not picked"
}

# refused WORDS COMMAND... : exit 1 and one line on stderr, besides progress, that holds the words.
refused() {
  local words=$1
  shift
  expect 1 "$@"
  [ "$(grep -c '^pickbed: ' last.err)" = 1 ] || fail "not one line of: $*"
  grep '^pickbed: ' last.err | grep -qF -- "$words" || fail "'$words' is not said of: $*"
}

# brick SCALE: an OBJ of 60 x 40 x 20 units.
brick() {
  for z in -10 10; do for y in -20 20; do for x in -30 30; do
    echo "v $((x * $1)) $((y * $1)) $((z * $1))"
  done; done; done
  printf 'f %s\n' '1 3 4 2' '5 6 8 7' '1 2 6 5' '3 7 8 4' '1 5 7 3' '2 4 8 6'
}

grasps_are_written_and_drawn() {
  local quick=(--count 20 --set antipodal.max_pairs=80 --set suction.max_samples=300
    --set robust.samples=4)
  for gripper in jaw_8cm cup_30mm; do
    expect 0 "$pickbed" grasps carton $gripper "${quick[@]}" --out $gripper
    [ "$(wc -l <$gripper/grasps.csv)" = 21 ] || fail "not 20 grasps with $gripper"
    [ -s $gripper/grasps.png ] || fail "no picture"
    expect 0 env XDG_CACHE_HOME="$work/cache" "$pickbed" grasps carton $gripper "${quick[@]}" \
      --out again
    same $gripper/grasps.csv again/grasps.csv
    same $gripper/grasps.png again/grasps.png
  done

  # 100 mm at its narrowest.
  brick 5 >big.obj
  expect 0 "$pickbed" object add big.obj --name big --unit mm --mass 0.5 --drops 5
  refused "part 'big' has no antipodal pair that fits its stroke for gripper 'jaw_8cm', but" \
    "$pickbed" grasps big jaw_8cm "${quick[@]}" --out none
  grep -q "cup_30mm has 20" last.err || fail "suction is not offered"
  [ ! -e none ] || fail "a refused command left a folder"
  refused "did you mean 'carton'" "$pickbed" grasps cartn jaw_8cm
  refused "unknown gripper 'claw'" "$pickbed" grasps carton claw
  refused "robust.samples" "$pickbed" grasps carton jaw_8cm --set robust.samples=0
}

bad_meshes_are_refused() {
  local add=("$pickbed" object add) name=(--name x --drops 5)
  brick 1 | sed 's/^v 30 20 10$/v nan 20 10/' >nan.obj
  refused "nan.obj' has vertices that are not numbers" "${add[@]}" nan.obj "${name[@]}"
  { brick 1 | grep -v '^f'; echo 'f 1 2 3'; } >one.obj
  refused "one.obj' encloses no volume" "${add[@]}" one.obj "${name[@]}"
  brick 1 | sed 's/10$/0/' >flat.obj
  refused "flat.obj' encloses no volume" "${add[@]}" flat.obj "${name[@]}"
  brick 20000 >vast.obj
  refused "check --unit" "${add[@]}" vast.obj "${name[@]}"
  brick 1 >brick.stl
  refused "its extension says what it is" "${add[@]}" brick.stl "${name[@]}"
  refused "nowhere.obj" "${add[@]}" nowhere.obj "${name[@]}"
  { # 5 million faces by its header; nothing else of it is read
    printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n'
    printf 'property float z\nelement face 5000000\nproperty list uchar int vertex_indices\n'
    printf 'end_header\n'
  } >many.ply
  refused "many.ply' has 5000000 faces; reduce it to 1000000" "${add[@]}" many.ply "${name[@]}"
  [ ! -e objects/x ] || fail "a refused mesh left a part"

  # What is missing beside a mesh is said, and the part is made.
  { echo "mtllib gone.mtl"; brick 1; } >plain.obj
  expect 0 "${add[@]}" plain.obj --name plain --drops 5
  grep -q "'gone.mtl' is missing" last.out || fail "the missing .mtl is not named"
  printf 'newmtl a\nmap_Kd gone.png\n' >there.mtl
  { echo "mtllib there.mtl"; brick 1; } >bare.obj
  expect 0 "${add[@]}" bare.obj --name bare --drops 5
  grep -q "'gone.png' is missing" last.out || fail "the missing texture is not named"
}

bad_scenes_are_refused() {
  brick 1 >brick.obj
  cat >bricks.yaml <<'YAML'
bin: {inner_size_m: [0.4, 0.3, 0.15]}
objects:
  - {name: brick, mesh: brick.obj, unit: mm, mass_kg: 0.1, count: 2}
YAML
  local drop=("$pickbed" drop bricks.yaml --out out)
  refused "larger than the bin" "${drop[@]}" --set objects.0.unit=cm
  refused "bricks.yaml:3: objects.0.mesh" "${drop[@]}" --set objects.0.unit=m
  refused "lower the count" "${drop[@]}" --set objects.0.count=1000
  refused "does not exist" "${drop[@]}" --set objects.0.mesh=nowhere.obj
  refused "inside the bin or its wall" "${drop[@]}" --set 'camera.eye_m=[0.203, 0, 0.1]'
  refused "under the bin's floor" "${drop[@]}" --set 'camera.eye_m=[0, 0, -1]'
  refused "did you mean 'wall_m'" "${drop[@]}" --set bin.wal_m=0.01
  [ ! -e out ] || fail "a refused scene left a folder"
  expect 0 "${drop[@]}"
}

bad_bop_data_is_refused() {
  echo "camera: {width: 96, height: 72, focal_px: 100}" >>small.yaml
  expect 0 "$pickbed" dataset make small.yaml --scenes 1 --views 2 --jobs 1 --out set
  expect 0 "$pickbed" dataset check set
  grep -q "no fault" last.out || fail "a fault is seen where none is"
  local gt=set/test/000001/scene_gt.json
  cp -r set sound

  sed -i 's/"cam_R_m2c":\[[^,]*,/"cam_R_m2c":[2.0,/g' $gt
  refused "faults, listed above" "$pickbed" dataset check set
  grep -q "scene_gt.json: image 1: instance 4: 'cam_R_m2c': is no rotation" last.out ||
    fail "the last of the matrices is not named"
  refused "scene_gt.json: image 0: instance 0: 'cam_R_m2c': is no rotation" \
    "$pickbed" estimate --bop set --set estimator.name=ppf --out look
  cp sound/test/000001/scene_gt.json $gt

  # 8 bits: a mask in the place of the last depth image.
  cp set/test/000001/mask/000001_000000.png set/test/000001/depth/000001.png
  refused "faults, listed above" "$pickbed" dataset check set
  grep -q "depth/000001.png' as depth: it is not 16 bits" last.out || fail "8 bits are not named"
  refused "depth/000001.png' as depth: it is not 16 bits" \
    "$pickbed" estimate --bop set --set estimator.name=ppf --out look
  rm set/test/000001/depth/000001.png
  refused "depth/000001.png: is missing" \
    "$pickbed" estimate --bop set --set estimator.name=ppf --out look

  local header="scene_id,im_id,obj_id,score,R,t,time" turn="1 0 0 0 1 0 0 0 1"
  printf '%s\n1,0,9,1,%s,0 0 500,-1\n' "$header" "$turn" >stranger.csv
  refused "stranger.csv:2: obj_id 9" "$pickbed" score --bop sound stranger.csv
  printf '%s\n1,0,1,1,%s,0 nan 500,-1\n' "$header" "$turn" >nan.csv
  refused "nan.csv:2: t 'nan'" "$pickbed" score --bop sound nan.csv
  printf 'im_id,scene_id,obj_id,score,R,t,time\n' >columns.csv
  refused "columns.csv:1: begins with" "$pickbed" score --bop sound columns.csv
}

a_tolerance_map_stops_and_resumes() {
  local few=(--set grasps=3 --set steps=2 --set step_mm=4 --set fit_tries=30 --set test_tries=30)
  local map=("$pickbed" tolerance rod jaw_8cm --pairs gx:gry "${few[@]}")
  expect 0 "${map[@]}" --jobs 1 --out one
  grep -q "along the closing direction" last.out || fail "no table of the axes"
  grep -q "^  mssd" last.out || fail "no table of the scores"
  for file in map.png pairs.png model.yaml tolerance.yaml; do
    [ -s "one/$file" ] || fail "no $file"
  done
  refused "pass --resume" "${map[@]}" --out one
  refused "other settings" "${map[@]}" --out one --resume --set seed=3
  mkdir two
  head -60 one/tries.csv >two/tries.csv
  expect 0 "${map[@]}" --jobs 2 --out two --resume
  for file in tries.csv axes.csv pairs.csv predictors.csv model.yaml; do
    same "one/$file" "two/$file"
  done
  brick 10 >wide.obj
  expect 0 "$pickbed" object add wide.obj --name wide --unit mm --mass 1
  refused "part 'wide' has no antipodal pair that fits its stroke for gripper 'jaw_8cm', but" "$pickbed" tolerance wide jaw_8cm --out wide
  [ ! -e wide ] || fail "a refused map left a folder"
  refused "did you mean 'gy'" "${map[@]}" --pairs gx:gyy --out three
  refused "axes of one frame" "${map[@]}" --pairs x:gx --out three
  refused "did you mean 'rod'" "$pickbed" tolerance rodd jaw_8cm
}

tolerance_maps_score_the_poses_of_runs() {
  expect 0 "$pickbed" tolerance rod jaw_8cm --set grasps=3 --set steps=2 --set step_mm=4 \
    --set fit_tries=30 --set test_tries=30 --out maps/rod
  cp small.yaml here.yaml
  expect 0 "$pickbed" run here.yaml "${noisy[@]}" --tolerance maps --out one
  grep -q "^Picks of rod by their pose errors" last.out || fail "no forecast"
  grep -q '"pick_forecasts"' one/summary.json || fail "no forecast in summary.json"
  head -1 one/picks.csv | grep -q ",p_pick," || fail "picks.csv has no p_pick"
  [ "$(grep -c "^[01],[0-9]*,[0-9]*,rod,[0-9-]*,[01]\.[0-9]*$" one/pick_chances.csv)" -gt 3 ] ||
    fail "hypotheses have no chance"
  expect 0 "$pickbed" run here.yaml "${noisy[@]}" --tolerance maps/rod/model.yaml --out two --jobs 1
  for file in picks.csv pick_chances.csv summary.json; do same "one/$file" "two/$file"; done
  expect 0 "$pickbed" budget one --stages none --tolerance maps
  grep -q "What pose errors foretell" one/budget/index.html || fail "the page tells no forecast"
  grep -q "bins are few" one/budget/index.html || fail "two bins are not said to be few"
  expect 0 "$pickbed" estimate here.yaml "${noisy[@]:0:4}" --trials 1 --tolerance maps --out poses
  head -1 poses/hypotheses.csv | grep -q ",p_pick$" || fail "hypotheses.csv has no p_pick"
  refused "is of rod with jaw_8cm; the parts are rod, flange, the gripper is jaw_14cm" \
    "$pickbed" run here.yaml --set gripper=jaw_14cm --tolerance maps/rod --out no
  cp -r maps/rod maps/again
  refused "are both of rod with jaw_8cm" "$pickbed" run here.yaml --tolerance maps --out no
  refused "there is no such file" "$pickbed" run here.yaml --tolerance nowhere --out no
  refused "write ID=PLACE" "$pickbed" score --bop none none.csv --tolerance maps
}

doctor_finds_nothing() {
  expect 0 "$pickbed" doctor
  [ "$(grep -c '^ok' last.out)" = 5 ] || fail "not all are ok"
}

"$name"
