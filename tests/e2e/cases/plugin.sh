# Cases of estimators and planners that are other programs.

root=$here/../..

# _estimator_with BODY: writes estimator.py, whose function returns no poses after BODY.
_estimator_with() {
  cat >estimator.py <<PY
import os, sys, time
import numpy as np
import pickbed_plugin as pb
@pb.estimator
def mine(frame):
    name = frame.setup.objects[0].name
    $1
    return []
pb.serve()
PY
}
plugged=(--set estimator.name=process --pictures 0 --set policy.max_attempts=2)

a_run_with_a_failing_program_goes_on_and_says_so() {
  _estimator_with 'print("seen"); raise ValueError("planted")'
  expect 0 "$pickbed" run small.yaml "${plugged[@]}" --trials 2 --set "estimator.command=python3 estimator.py" --jobs 2 --out crashed
  grep -q "estimator_crashed *4" last.out || grep -q "estimator_crashed" last.out || fail "the failures are not reported"
  grep -q "attempt 0: estimator 'mine' reported an error: ValueError: planted" last.err || fail "no warning"
  grep -q 'estimator.py", line 7' last.err || fail "no traceback"
  grep -q "seen" crashed/logs/estimator_1.log || fail "the prints are not in the log"
  # The worker with the other program started later must give the same results.
  expect 0 "$pickbed" run small.yaml "${plugged[@]}" --trials 2 --set "estimator.command=[python3, estimator.py]" --jobs 1 --out again
  same crashed/attempts.csv again/attempts.csv
  same crashed/summary.json again/summary.json
}

a_program_that_hangs_costs_its_attempts() {
  _estimator_with 'time.sleep(60)'
  expect 0 "$pickbed" run small.yaml "${plugged[@]}" --trials 1 --set estimator.timeout_s=1 \
    --set "estimator.command=python3 estimator.py" --out hung
  grep -q "estimator_timeout" last.out || fail "the failures are not reported"
}

# _refused_run WORDS OPTION...: a run with these options is refused with the words.
_refused_run() {
  local words=$1
  shift
  rm -rf no
  refused "$words" "$pickbed" run small.yaml "${plugged[@]}" --trials 2 --out no "$@"
}

wrong_programs_are_refused_in_one_line() {
  _refused_run "neither command nor connect is given"
  _refused_run "cannot start 'no_such_program': No such file" --set estimator.command=no_such_program
  _refused_run "'true' ended with status 0" --set estimator.command=true
  _refused_run "wrote 'hello, I am no plug-in' to its standard output" --set "estimator.command=[echo, 'hello, I am no plug-in']"
  _refused_run "cannot connect to localhost:1: Connection refused" --set estimator.connect=localhost:1
  _refused_run "both command and connect are given" --set estimator.connect=localhost:1 --set estimator.command=true
  _refused_run "must be a list of words" --set "estimator.command={a: 1}"
}

wrong_first_answers_are_refused_in_one_line() {
  local program=(--set "estimator.command=python3 estimator.py")
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, 800], 0.9)]'
  _refused_run "t_m is in millimetres and must be in metres" "${program[@]}"
  _estimator_with 'return [pb.Pose(name, np.diag([1, 1, -1]), [0, 0, 0.8], 0.9)]'
  _refused_run "R is a reflection" "${program[@]}"
  _estimator_with 'return [pb.Pose("tube", np.eye(3), [0, 0, 0.8], 0.9)]'
  _refused_run "unknown object 'tube'" "${program[@]}"
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, float("nan")], 0.9)]'
  _refused_run "t_m is not finite" "${program[@]}"
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, 0.8], 0.9)] * 20000'
  _refused_run "gave 20000 poses" "${program[@]}"
}

a_changed_program_makes_other_results() {
  _estimator_with 'return []'
  local run=("$pickbed" run small.yaml "${plugged[@]}" --trials 1 --set policy.max_attempts=1 --set "estimator.command=python3 estimator.py" --out kept)
  expect 0 "${run[@]}"
  expect 0 "${run[@]}" --resume
  _estimator_with 'name = "other"'
  expect 1 "${run[@]}" --resume
}

a_wrong_first_plan_is_refused_in_one_line() {
  cat >planner.py <<PY
import numpy as np
import pickbed_plugin as pb
@pb.planner
def mine(frame, poses):
    return [pb.Grasp(np.diag([1, 1, -1, 1]), 0.02, 0.5)]
pb.serve()
PY
  refused "planner 'mine' gave a wrong grasp (number 0): X_WG is a reflection" "$pickbed" run small.yaml \
    --set planner.name=process --set "planner.command=python3 planner.py" --pictures 0 --trials 2 --out no
}

a_changed_server_makes_other_results() {
  _estimator_with 'return []'
  local run=("$pickbed" run small.yaml "${plugged[@]}" --trials 1 --set policy.max_attempts=1 --out kept)
  local version server address
  for version in 1 1 2; do
    sed -i "s/^@pb.estimator.*/@pb.estimator(version='$version')/" estimator.py
    rm -f server.log  # of the server before
    PYTHONPATH=$root/scenes/plugin/python python3 estimator.py --listen "${address:-0}" 2>server.log &
    server=$!
    for _ in $(seq 100); do grep -qs "listening" server.log && break; sleep 0.1; done
    address=$(sed -n 's/^listening on //p' server.log)
    [ -e kept ] && run+=(--resume)
    "${run[@]}" --set "estimator.connect=$address" >last.out 2>last.err
    local status=$?
    kill $server
    wait $server 2>/dev/null
    [ $status = $((version - 1)) ] || fail "exit status $status with version $version"
  done
  grep -q "already has results of other settings" last.err || fail "no reason"
}

raw_scores_need_a_calibration() {
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, 0.8], -120)]'
  local run=("$pickbed" run small.yaml "${plugged[@]}" --trials 6 --set policy.max_attempts=1 \
    --set "estimator.command=python3 estimator.py")
  refused "score -120 is outside 0 to 1" "${run[@]}" --out no
  grep -q "estimator.scores=raw" last.err || fail "no remedy"
  expect 0 "${run[@]}" --set estimator.scores=raw --out raw
  refused "raw has 6 poses, but 30 are needed" "$pickbed" calibrate raw
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --pictures 0 --out oracle
  refused "its estimator is the oracle" "$pickbed" calibrate oracle
  refused "none has no results.sqlite" "$pickbed" calibrate none
}

an_answer_larger_than_allowed_ends_the_run() {
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, 0.8], 0.9)] * 400000'
  expect 1 "$pickbed" run small.yaml "${plugged[@]}" --trials 2 --out no --set "estimator.command=python3 estimator.py"
  grep -q "gave an answer of more than 64 MiB" last.err || fail "no reason"
}

a_planner_program_picks_and_its_failures_are_reported() {
  local pose_free=(--set planner.name=process --pictures 0 --set policy.max_attempts=2 --trials 2)
  local example="python3 $root/scenes/plugin/python/examples/cloud_grasps.py"
  expect 0 "$pickbed" run small.yaml "${pose_free[@]}" --set "planner.command=$example" --jobs 2 --out planned
  expect 0 "$pickbed" run small.yaml "${pose_free[@]}" --set "planner.command=$example" --jobs 1 --out again
  same planned/attempts.csv again/attempts.csv
  grep -q "planner_crashed\|planner_timeout" planned/attempts.csv && fail "the example failed"
  cat >planner.py <<PY
import pickbed_plugin as pb
@pb.planner
def mine(frame, poses):
    raise ValueError("planted")
pb.serve()
PY
  expect 0 "$pickbed" run small.yaml "${pose_free[@]}" --set "planner.command=python3 planner.py" --out crashed
  grep -q "planner_crashed" crashed/attempts.csv || fail "the failures are not recorded"
  grep -q "attempt 0: planner 'mine' reported an error: ValueError: planted" last.err || fail "no warning"
  rm -rf no
  refused "neither command nor connect is given" "$pickbed" run small.yaml "${pose_free[@]}" --out no
}

a_server_answers_several_workers() {
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, 0.8], 0.9)]'
  PYTHONPATH=$root/scenes/plugin/python python3 estimator.py --listen 0 2>server.log &
  local server=$!
  for _ in $(seq 100); do grep -q "listening" server.log && break; sleep 0.1; done
  local address=$(sed -n 's/^listening on //p' server.log)
  expect 0 "$pickbed" run small.yaml "${plugged[@]}" --trials 2 --set "estimator.connect=$address" --jobs 2 --out served
  [ "$(grep -c . served/attempts.csv)" -ge 3 ] || fail "too few attempts"
  kill $server
  expect 0 "$pickbed" run small.yaml "${plugged[@]}" --trials 2 --set "estimator.command=python3 estimator.py" --out child
  cut -d, -f1-8 served/attempts.csv >a.csv
  cut -d, -f1-8 child/attempts.csv >b.csv
  same a.csv b.csv
}

plugin_check_prints_what_to_correct() {
  _estimator_with 'return [pb.Pose(name, np.eye(3), [0, 0, 0.8], 0.9)] if frame.depth_m.any() else [1 / 0]'
  expect 1 "$pickbed" plugin check "python3 estimator.py" --set objects.0.count=3
  grep -q "^ok *answer" last.out || fail "the answer is not checked"
  grep -q "^not ok *blank" last.out || fail "the blank image is not checked"
  grep -q "ZeroDivisionError" last.out || fail "no traceback"
  grep -q "1 check failed" last.err || fail "no count"
  refused "give either COMMAND or --connect" "$pickbed" plugin check
  _estimator_with 'time.sleep(60)'
  "$pickbed" plugin check "python3 estimator.py" --timeout 1 >last.out 2>last.err
  cat last.out last.err | grep -q "raise timeout_s (--timeout)" || fail "--timeout is not named"
}

# _found AT_LEAST COMMAND...: runs plugin check and expects that so many of three instances are found.
_found() {
  local wanted=$1
  shift
  expect 0 "$pickbed" plugin check "$@" --set objects.0.count=3 --images 1
  local found=$(sed -n 's/^ok *accuracy .*; \([0-9]*\) of 3 visible.*/\1/p' last.out)
  [ "${found:-0}" -ge "$wanted" ] || fail "$(grep accuracy last.out), expected $wanted"
}

python_examples_find_poses_and_grasps() {
  local examples=$root/scenes/plugin/python/examples
  _found 1 "python3 $examples/opencv_ppf.py" --timeout 300
  _found 2 "python3 $examples/template_lookup.py" --set arrangement=packed
  expect 0 "$pickbed" plugin check "python3 $examples/cloud_grasps.py" --role planner --set objects.0.count=3 --images 1
  local inside=$(sed -n 's/^ok *place *\([0-9]*\) of .*/\1/p' last.out)
  [ "${inside:-0}" -ge 5 ] || fail "$(grep place last.out)"
}
