# Cases of pickbed dataset and of the commands that read its data sets.

# The images show three rods, but the targets ask for two.
bop_task_decides_whether_instance_counts_are_given() {
  echo "camera: {width: 160, height: 120, focal_px: 170}" >>rods.yaml
  expect 0 "$pickbed" dataset make rods.yaml --scenes 1 --views 1 --jobs 1 --out set
  sed -i 's/"inst_count": *[0-9]*/"inst_count": 2/' set/test_targets_bop19.json
  local all="--set estimator.min_score=0 --set estimator.mode=accurate"
  expect 0 "$pickbed" estimate --bop set $all --out given
  [ "$(wc -l <given/descriptor_set-test.csv)" = 3 ] || fail "not the two requested rods"
  expect 0 "$pickbed" estimate --bop set $all --task detection --out free
  head -3 free/descriptor_set-test.csv | cut -d, -f1-6 >best
  cut -d, -f1-6 given/descriptor_set-test.csv | diff - best >&2 || fail "they are not the best two"
  [ "$(wc -l <free/descriptor_set-test.csv)" -gt 3 ] || fail "detection was given the number of instances"
  expect 0 "$pickbed" estimate --bop set $all
  grep -q "AP is comparable only after --task detection" last.out || fail "the note about AP is missing"
  expect 0 "$pickbed" estimate --bop set $all --task detection
  grep -q "AP is comparable" last.out && fail "the note about AP also appears for detection"
  local task
  for task in given/set-estimate free/set-estimate-detection; do
    cut -d, -f1-6 "${task%/*}/descriptor_set-test.csv" >expected
    cut -d, -f1-6 "results/${task#*/}/descriptor_set-test.csv" | diff - expected >&2 ||
      fail "the poses of ${task%/*} are not in results/${task#*/}"
  done
  expect 0 "$pickbed" estimate --bop set --without-cell $all --task detection --out blind
  cut -d, -f1-6 blind/descriptor_set-test.csv | cmp -s - expected &&
    fail "without the stored cell, the poses are the same"
  expect 0 "$pickbed" estimate --bop set --explain 0
  page results/set-bop-explain/explain_image_1_0.html "The number of instances of each object was given, 2 in all"
  expect 0 "$pickbed" estimate --bop set --explain 0 --task detection
  page results/set-bop-explain-detection/explain_image_1_0.html
  has_template && grep -q "The number of instances" results/set-bop-explain-detection/explain_image_1_0.html &&
    fail "the page of detection shows a given number of instances"
  refused "segmentation" "$pickbed" estimate --bop set --task segmentation --out no
}

invalid_bop_data_is_refused() {
  echo "camera: {width: 96, height: 72, focal_px: 100}" >>small.yaml
  expect 0 "$pickbed" dataset make small.yaml --scenes 1 --views 2 --jobs 1 --out set
  expect 0 "$pickbed" dataset check set
  grep -q "no fault" last.out || fail "a fault is reported in a sound set"
  local gt=set/test/000001/scene_gt.json
  cp -r set sound

  sed -i 's/"cam_R_m2c":\[[^,]*,/"cam_R_m2c":[2.0,/g' $gt
  refused "faults, listed above" "$pickbed" dataset check set
  grep -q "scene_gt.json: image 1: instance 4: 'cam_R_m2c': is no rotation" last.out ||
    fail "the last wrong matrix is not named"
  cp sound/test/000001/scene_gt.json $gt
  sed -i 's/"cam_t_m2c"/"cam_t"/g' $gt
  refused "scene_gt.json: image 0: instance 0: has no 'cam_t_m2c'" \
    "$pickbed" estimate --bop set --set estimator.name=ppf --out look
  cp sound/test/000001/scene_gt.json $gt

  # An 8-bit mask replaces the last depth image.
  cp set/test/000001/mask/000001_000000.png set/test/000001/depth/000001.png
  refused "fault, listed above" "$pickbed" dataset check set
  grep -q "depth/000001.png' as depth: it is not 16 bits" last.out || fail "the 8-bit image is not named"
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

# The estimator breaks another image while it works on one.
estimates_resume_after_an_interrupt_and_a_broken_image() {
  echo "camera: {width: 96, height: 72, focal_px: 100}" >>small.yaml
  expect 0 "$pickbed" dataset make small.yaml --scenes 1 --views 3 --jobs 1 --out set
  cp -r set/test/000001/depth sound
  cat >estimator.py <<'PY'
import os
import signal
import numpy as np
import pickbed_plugin as pb
@pb.estimator
def mine(frame):
    if os.path.exists("break"):
        open("set/test/000001/depth/00000%s.png" % open("break").read(), "w").close()
    if os.path.exists("stop"):
        os.kill(os.getppid(), signal.SIGTERM)
    name = "stranger" if os.path.exists("stranger") else frame.setup.objects[0].name
    return [pb.Pose(name, np.eye(3), [0, 0, 0.8], 0.9)]
pb.serve()
PY
  local estimate=("$pickbed" estimate --bop set --set estimator.name=process --set "estimator.command=python3 estimator.py" --out poses)
  local partial=poses/process_set-test.partial.csv
  expect 0 "${estimate[@]}"
  [ "$(wc -l <poses/process_set-test.csv)" = 4 ] || fail "not one pose in each image"
  [ "$(cut -d, -f3 poses/process_set-test.images.csv | tr '\n' ' ')" = "poses 1 1 1 " ] || fail "other numbers of poses in the list of images"
  [ -e $partial ] && fail "partial results of a complete run"
  [ -e "${partial%.csv}.images.csv" ] && fail "a partial list of images of a complete run"
  mv poses whole

  touch stop
  expect 130 "${estimate[@]}"
  [ "$(grep '^pickbed: ' last.err)" = "pickbed: interrupted; the estimates of 1 of 3 images are in $partial; resume it (--resume)" ] ||
    fail "an interrupt does not name the partial results"
  [ "$(wc -l <$partial)" = 2 ] || fail "not the poses of the first image"
  [ "$(wc -l <"${partial%.csv}.images.csv")" = 2 ] || fail "not a list of the first image"
  rm stop

  refused "$partial has the estimates of an interrupted run (images: 1); resume it (--resume)" "${estimate[@]}"
  refused "(seed: 0 before, 5 now)" "${estimate[@]}" --resume --set seed=5
  refused "(task: localisation before, detection now)" "${estimate[@]}" --resume --task detection
  refused "leave --resume out" "${estimate[@]}" --resume --explain 0
  # A wrong answer ends the work only in the first image, where it is a fault of the program.
  cp -r poses interrupted
  touch stranger
  expect 0 "${estimate[@]}" --resume
  [ "$(cut -d, -f3 poses/process_set-test.images.csv | tr '\n' ' ')" = "poses 1 0 0 " ] || fail "the first resumed image was taken as the first one"
  rm -r stranger poses
  mv interrupted poses
  cp set/test/000001/scene_camera.json sound
  sed -i 's/"cam_K": *\[/&1/' set/test/000001/scene_camera.json
  refused "(list of the cameras has changed)" "${estimate[@]}" --resume
  cp sound/scene_camera.json set/test/000001
  rm sound/scene_camera.json
  # Lines of the image in which a killed process was.
  printf '1,1,1,0.9,1 0 0 0 1 0 0 0 1,0 0 8' >>$partial
  printf 2 >break
  refused "depth/000002.png" "${estimate[@]}" --resume
  grep '^pickbed: ' last.err | grep -q "the estimates of 2 of 3 images are in $partial" || fail "the partial results are not named"
  head -3 whole/process_set-test.csv | cut -d, -f1-6 | diff - <(cut -d, -f1-6 $partial) >&2 ||
    fail "other poses of the first images"
  [ -e poses/process_set-test.csv ] && fail "the results look complete"
  rm break
  cp sound/* set/test/000001/depth
  expect 0 "${estimate[@]}" --resume
  for file in process_set-test.csv process_set-test.images.csv; do
    diff <(cut -d, -f1-6 whole/$file) <(cut -d, -f1-6 poses/$file) >&2 || fail "the resumed $file is another one"
  done
  [ -z "$(ls poses | grep partial)" ] || fail "partial results of a complete run"
  refused "there is no poses/process_set-test.partial.yaml of an interrupted run" "${estimate[@]}" --resume

  : >set/test/000001/depth/000001.png
  refused "depth/000001.png" "${estimate[@]}"
  grep -q "the estimates of" last.err && fail "there are estimates before the first image"
  return 0
}

results_files_are_executed_in_the_scenes_of_a_dataset() {
  echo "camera: {width: 320, height: 240, focal_px: 340}" >>small.yaml
  expect 0 "$pickbed" dataset make small.yaml --scenes 2 --views 1 --jobs 2 --out set
  expect 0 "$pickbed" dataset truth set --out truth.csv
  expect 0 "$pickbed" execute --dataset set truth.csv --oracle --gripper jaw_8cm --picks 2 --jobs 2
  grep -q "A is truth, B is oracle" last.out || fail "no paired difference"
  page results/set-execute/report.html "Pose errors and outcomes"
  grep '^truth,' results/set-execute/executed_picks.csv | cut -d, -f2-4,14-15 >of_file
  grep '^oracle,' results/set-execute/executed_picks.csv | cut -d, -f2-4,14-15 | diff of_file - >&2 ||
    fail "the true poses of the file and of the oracle differ"
  refused "resume it (--resume)" "$pickbed" execute --dataset set truth.csv --oracle --picks 2 --gripper jaw_8cm
  expect 0 "$pickbed" execute --dataset set truth.csv --oracle --picks 2 --gripper jaw_8cm --resume
  refused "choose another results folder (--out)" "$pickbed" execute --dataset set truth.csv --picks 1
  sed -E 's/^([^,]*,[^,]*,)1,/\19,/' truth.csv >stranger.csv
  refused "obj_id 9: models_info.json has no such object" "$pickbed" execute --dataset set stranger.csv --out no
  refused "only planner.* and policy.*" "$pickbed" execute --dataset set truth.csv --set seed=3 --out no
  rm set/test/000002/stored_scenes.json
  refused "stored_scenes.json: is missing" "$pickbed" execute --dataset set truth.csv --out no
}

every_image_of_a_run_is_in_its_dataset() {
  echo "camera: {width: 160, height: 120, focal_px: 170}" >>small.yaml
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --jobs 1 --pictures 0 --out run --bop-out set
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 2 --jobs 1 --pictures 0 --out run --bop-out set --resume
  expect 0 "$pickbed" dataset check set
  local images attempts
  images=$(ls set/test/*/rgb | grep -c png)
  attempts=$(($(wc -l <run/attempts.csv) - 1))
  [ "$images" = "$attempts" ] || fail "$images images of $attempts attempts"
  expect 0 "$pickbed" execute --dataset set --oracle --picks 1 --out picks
  refused "choose another image folder (--bop-out)" "$pickbed" run small.yaml "${small[@]}" --set seed=8 --out other --bop-out set --resume
  refused "choose another image folder (--bop-out)" "$pickbed" run small.yaml "${small[@]}" --out other --bop-out small.yaml/set
}
