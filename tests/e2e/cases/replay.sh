# Cases of pickbed replay.

replay_reproduces_every_stage() {
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  expect 0 "$pickbed" replay one#1
  grep -q "^all recorded stages are the same" last.out || fail "the replay does not report that all is the same"
  grep -q "^attempt 0: 5 of 5 stages are the same" last.out || fail "the attempts are not listed"
  for file in color.png depth.png ids.png overlay.png after.png cloud.ply hypotheses.ply scene.glb; do
    [ -s "one/replay/trial_0001/attempt_00_$file" ] || fail "no $file"
  done
  # An occlusion trial, at the second configuration of a sweep.
  cat >occlusion.yaml <<'YAML'
scenario: small.yaml
trials: 2
set: {estimator.name: oracle}
occlusion: {enabled: true, bands: [{min: 0.3, max: 0.6}, {min: 0.9, max: 1}]}
grid: {noise: {none: {estimator.noise_mm: 0}, much: {estimator.noise_mm: 9}}}
YAML
  expect 0 "$pickbed" sweep occlusion.yaml --out hidden
  expect 0 "$pickbed" replay hidden#3
  [ "$(grep -c "^attempt [01]: 5 of 5 stages are the same" last.out)" = 2 ] || fail "not two attempts"
  [ -s hidden/replay/trial_0003/attempt_01_scene.glb ] || fail "no second attempt"
  # From another working folder, and a trial with ground truth substituted.
  expect 0 "$pickbed" budget one --stages pose
  cd / || fail "cannot change the folder"
  "$pickbed" replay "$work/one#0" --out "$work/elsewhere" >"$work/last.out" || fail "the replay from another folder differs"
  [ -s "$work/elsewhere/stages.csv" ] || fail "no stages.csv"
  "$pickbed" replay "$work/one/budget/pose#1" >"$work/last.out" 2>"$work/last.err" ||
    fail "the replay of a budget rerun differs"
  grep -q "^attempt 0: 5 of 5 stages are the same" "$work/last.out" || fail "the attempts of the rerun are not listed"
}

replay_animates_picks() {
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  expect 0 "$pickbed" replay one#1 --animate --attempt 0
  grep -q "^1 animation in" last.out || fail "the number of animations is not reported"
  head -c 6 one/replay/trial_0001/attempt_00_pick.gif | grep -q GIF89a || fail "no GIF"
  grep -aq '"animations":' one/replay/trial_0001/attempt_00_pick.glb || fail "no animation in the GLB"
  [ ! -e one/replay/trial_0001/attempt_01_pick.gif ] || fail "an attempt was animated that was not asked for"
  refused "attempt 99: the trial has attempts 0 to" "$pickbed" replay one#1 --animate --attempt 99
  # A minimum score that no pose reaches: no attempt executes a grasp.
  expect 0 "$pickbed" run rods.yaml --set estimator.name=ppf --set estimator.min_score=1 --trials 1 --out none
  refused "no attempt of the trial executed a grasp" "$pickbed" replay none#0 --animate
}

replay_animates_stirs() {
  # A minimum score that no pose reaches: the first attempt only stirs.
  expect 0 "$pickbed" run rods.yaml --set estimator.name=ppf --set estimator.min_score=1 --set policy.stir.max=1 \
    --trials 1 --pictures 0 --out stirred
  expect 0 "$pickbed" replay stirred#0 --animate
  grep -q "^1 animation in" last.out || fail "not only the stir is animated"
  grep -aq '"animations":' stirred/replay/trial_0000/attempt_00_pick.glb || fail "no animation of the stir"
}

replay_names_the_changed_setting() {
  cp "$here/../../assets/grippers/jaw_8cm.yaml" jaw.yaml
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --set gripper=jaw.yaml --out one
  sed -i 's/^clearance_m: .*/clearance_m: 0.006/' jaw.yaml
  expect 1 "$pickbed" replay one#1
  grep -q "^changed since the trial ran: was 'clearance_m: 0.003', is 'clearance_m: 0.006'" last.out ||
    fail "the changed setting is not named"
  grep -q "^first difference: attempt 0, stage grasp" last.out || fail "the stage is not named"
}

invalid_replay_requests_are_refused() {
  refused "one: the trial number is missing; write RUN#TRIAL, for instance one#0" "$pickbed" replay one
  refused "there is no folder nowhere" "$pickbed" replay nowhere#1
  mkdir empty
  refused "empty has no results.sqlite" "$pickbed" replay empty#1
  expect 0 "$pickbed" run small.yaml "${noisy[@]}" --out one
  refused "one#7: the run has no such trial" "$pickbed" replay one#7
  refused "one#x: 'x' is no trial number" "$pickbed" replay one#x
  head -c 5000 one/results.sqlite >cut && mv cut one/results.sqlite
  refused "results.sqlite" "$pickbed" replay one#1
}

programs_of_stored_results_start_only_if_allowed() {
  cat >estimator.py <<'PY'
import numpy as np
import pickbed_plugin as pb
open("started", "w").close()
@pb.estimator
def nothing(frame):
    return []
pb.serve()
PY
  expect 0 "$pickbed" run small.yaml --trials 1 --pictures 0 --set estimator.name=process \
    --set "estimator.command=python3 $work/estimator.py" --out one
  rm started
  refused "one#0: its settings use 'python3 $work/estimator.py'; allow it (--programs)" "$pickbed" replay one#0
  refused "allow it (--programs)" "$pickbed" budget one --stages grasp
  [ ! -e started ] || fail "a program of stored results was started"
  expect 0 "$pickbed" replay one#0 --programs
  [ -e started ] || fail "the program was not started"
}
