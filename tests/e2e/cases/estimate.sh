# Cases of pickbed estimate.

estimate_stops_on_interrupt() {
  "$pickbed" estimate small.yaml "${small[@]}" --trials 500 --out look 2>stopped.err >/dev/null &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^bin" stopped.err && break
    sleep 0.2
  done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "the exit status is not 130"
  grep -q "interrupted" stopped.err || fail "the interrupt is not reported"
}

estimate_scores_ground_truth_poses_as_correct() {
  expect 0 "$pickbed" estimate small.yaml --set estimator.name=oracle --trials 2 --out look
  head -1 look/hypotheses.csv | grep -q 'correct,p_pick,qw,qx,qy,qz,tx_m,ty_m,tz_m$' || fail "other columns than expected"
  local wrong=$(tail -n +2 look/hypotheses.csv | grep -vc ',1,,')
  [ "$wrong" = 0 ] || fail "$wrong ground truth poses were scored as wrong"
  [ "$(wc -l <look/hypotheses.csv)" -gt 5 ] || fail "too few hypotheses"
  [ -s look/pictures/trial_0001/oracle/attempt_00_overlay.png ] || fail "no overlay"
}

# _check_pictures FOLDER PAGE: every image that the explain page names exists, and every image is on the page.
_check_pictures() {
  page "$1/$2"
  has_template || return 0
  local pictures=$(grep -o 'src="[^"]*"' "$1/$2" | cut -d'"' -f2)
  [ "$(wc -w <<<"$pictures")" -ge 9 ] || fail "too few pictures in $1"
  for picture in $pictures; do [ -s "$1/$picture" ] || fail "no $1/$picture"; done
  [ "$(wc -w <<<"$pictures")" = "$(find "$1/pictures" -type f | wc -l)" ] ||
    fail "a picture in $1 is not shown"
}

explain_page_shows_every_stage() {
  expect 0 "$pickbed" estimate rods.yaml --explain 1 --out why
  _check_pictures why explain_trial_1.html
  has_template && ! grep -q "why/explain_trial_1.html" last.out && fail "the page is not named"
  for stage in 1 2 3 4 5 6 7 8; do page why/explain_trial_1.html "<h2>$stage."; done
  expect 0 "$pickbed" estimate rods.yaml --explain 1 --out again
  diff -r why again >&2 || fail "a second run explains the image in another way"
  expect 0 "$pickbed" estimate rods.yaml --explain 1 --out again
  has_template && ! grep -q "it replaces an earlier page of this image" last.out && fail "a page is replaced silently"

  echo "camera: {width: 160, height: 120, focal_px: 170}" >>rods.yaml
  expect 0 "$pickbed" dataset make rods.yaml --scenes 1 --views 2 --jobs 1 --out set
  expect 0 "$pickbed" estimate --bop set --explain 1/1 --out bop
  _check_pictures bop explain_image_1_1.html
  expect 0 "$pickbed" estimate --bop set --explain 1 --out same
  diff -r bop same >&2 || fail "1/1 is not the second target"
  # A 16-bit depth image of 160 x 120 zeros. Codebooks are then built for the camera of the next target.
  local blank=iVBORw0KGgoAAAANSUhEUgAAAKAAAAB4EAAAAAAAWXrwAAAAPElEQVR42u3BMQEAAADCoPVPbQlPoAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAB4GpZ4AAHxJknaAAAAAElFTkSuQmCC
  printf %s "$blank" | base64 -d >set/test/000001/depth/000000.png
  expect 0 "$pickbed" estimate --bop set --explain 1/1 --out behind
  _check_pictures behind explain_image_1_1.html
  cp set/test/000001/depth/000000.png set/test/000001/depth/000001.png
  refused "set/test: no target image has a depth reading" \
    "$pickbed" estimate --bop set --explain 1/1 --out no
  refused "image 7/0: is no target image; write SCENE/IMAGE, for example 1/0" \
    "$pickbed" estimate --bop set --explain 7/0 --out no
  refused "'ppf' does not report the stages" "$pickbed" estimate --bop set --explain 0 --estimator ppf --out no
  refused "this model belongs to 'descriptor', which --estimator does not name" "$pickbed" estimate demo --estimator ppf --set estimator.model=a.net --out no
  refused "--estimator ppf:first: estimator: unknown mode" "$pickbed" estimate demo --estimator ppf:first --out no
  refused "has no model after '='" "$pickbed" estimate demo --estimator kehl= --out no
  [ ! -e no ] || fail "a refused command left a folder"
}

broken_model_is_refused() {
  head -c 1000 /dev/urandom >broken.net
  expect 1 "$pickbed" run small.yaml --set estimator.name=descriptor \
    --set "estimator.model=$work/broken.net" --out broken
  grep -q "broken.net" last.err || fail "the file is not named"
  expect 1 "$pickbed" run small.yaml --set estimator.name=descriptor \
    --set "estimator.model=$work/missing.net" --out missing
  grep -q "missing.net" last.err || fail "the file is not named"
}

truncated_model_is_refused() {
  local model=$here/../../assets/models/shipped.net
  head -c 5000 "$model" >cut.net
  expect 1 "$pickbed" estimate small.yaml --set "estimator.model=$work/cut.net" --out cut
  grep -q "cut.net" last.err || fail "the file is not named"
  [ "$(wc -l <last.err)" = 1 ] || fail "more than one line"
}

# _image: makes color.png, depth.png, camera.json and part.ply of one simulated image.
_image() {
  expect 0 "$pickbed" dataset make rods.yaml --scenes 1 --views 1 --jobs 1 --set camera.width=320 \
    --set camera.height=240 --set camera.focal_px=340 --out set
  cp set/test/000001/rgb/000000.png color.png
  cp set/test/000001/depth/000000.png depth.png
  cp set/camera.json set/models/obj_000001.ply .
  mv obj_000001.ply part.ply
}

image_gives_overlay_and_poses() {
  _image
  local image=(color.png --depth depth.png --intrinsics camera.json)
  expect 0 "$pickbed" estimate "${image[@]}" --object rod --out poses
  [ -s poses/overlay.png ] && [ -s poses/poses.json ] || fail "a file is missing"
  head -1 poses/poses.csv | grep -q '^object,score,r11,.*,tx_m,ty_m,tz_m$' || fail "other columns"
  [ "$(grep -c '^rod,' poses/poses.csv)" -ge 2 ] || fail "too few poses"
  expect 0 "$pickbed" estimate "${image[@]}" --object rod --threads 2 --out again
  diff -r poses again >&2 || fail "a second estimate differs"
  expect 0 "$pickbed" estimate "${image[@]}" --object rod --set estimator.min_score=1 --out none
  [ "$(wc -l <none/poses.csv)" = 1 ] || fail "poses with low scores are reported"
  grep -q "estimator.min_score = 1 or more; lower it with --set estimator.min_score=0.1" last.err ||
    fail "no remedy without poses"
  # The right half of the poses (column 12 is tx_m).
  local half
  half=$(awk -F, 'NR > 1 { print $12 }' poses/poses.csv | sort -g |
    awk '{ last = $1; if (NR == 1) first = $1 } END { print (first + last) / 2 }')
  expect 0 "$pickbed" estimate "${image[@]}" --object rod --roi "camera:$half,-9,0.01,9,9,9" --out right
  awk -F, -v half="$half" 'NR > 1 && $12 < half { exit 1 }' right/poses.csv ||
    fail "poses outside the region are reported"
  [ "$(wc -l <right/poses.csv)" -gt 1 ] || fail "no pose in the region"
  expect 0 "$pickbed" estimate --bop set --roi camera:-9,-9,0.01,9,9,0.02 --out none
  [ "$(wc -l <none/descriptor_set-test.csv)" = 1 ] || fail "poses outside the region are reported"
  refused "region 'roi': no depth reading of the image is in it" \
    "$pickbed" estimate rods.yaml --set roi.max_m=[0.001,0.001,0.001] --out none
  refused "region 'roi': no depth reading of the image is in it" \
    "$pickbed" run rods.yaml --set roi.max_m=[0.001,0.001,0.001] --pictures 0 --out none_run
  expect 0 "$pickbed" estimate rods.yaml --trials 2 --set roi.min_m=[-9,-9,-1] --set roi.max_m=[9,9,0.002] --out none
  [ "$(wc -l <none/hypotheses.csv)" = 1 ] || fail "poses outside the region are reported"
}

image_with_bad_files_gets_one_line() {
  _image
  local image=(color.png --depth depth.png) k=(--intrinsics camera.json)
  refused "give the objects to search" "$pickbed" estimate "${image[@]}" "${k[@]}" --out no
  refused "give its depth image, too (--depth)" "$pickbed" estimate color.png "${k[@]}" --mesh part.ply --out no
  refused "intrinsics of the camera are needed (--intrinsics)" "$pickbed" estimate "${image[@]}" --mesh part.ply --out no
  refused "px wide" "$pickbed" estimate "${image[@]}" "${k[@]}" --mesh part.ply --unit cm --depth-scale 0.01 --out no
  refused "check the unit" "$pickbed" estimate "${image[@]}" "${k[@]}" --mesh part.ply --unit m --out no
  refused "the median depth would be" "$pickbed" estimate "${image[@]}" "${k[@]}" --mesh part.ply --depth-scale 1000 --out no
  refused "it has 3 channels" "$pickbed" estimate color.png --depth color.png "${k[@]}" --mesh part.ply --out no
  refused "principal point" "$pickbed" estimate "${image[@]}" --intrinsics 340,340,640,120 --mesh part.ply --out no
  refused "is not known; give the box in the camera frame" \
    "$pickbed" estimate "${image[@]}" "${k[@]}" --object rod --roi world:0,0,0,1,1,1 --out no
  refused "region 'camera:5,5,5,6,6,6': no depth reading of the image is in it" \
    "$pickbed" estimate "${image[@]}" "${k[@]}" --object rod --roi camera:5,5,5,6,6,6 --out no
  refused "--verifier-for ppf --out models/part.net\`, and then give --object part with --estimator ppf:verified=models/part.net" \
    "$pickbed" estimate "${image[@]}" "${k[@]}" --mesh part.ply --estimator ppf:verified --out no
  refused "--estimator ppf, which needs no training" "$pickbed" estimate "${image[@]}" "${k[@]}" --mesh part.ply --out no
  refused "neither --explain" "$pickbed" estimate "${image[@]}" "${k[@]}" --mesh part.ply --explain 1 --out no
  refused "a SCENARIO has the setting roi" "$pickbed" estimate rods.yaml --roi auto --out no
  refused "give only one of a box" "$pickbed" estimate rods.yaml --set roi.automatic=true --set roi.mask=a.png --out no
  [ ! -e no/poses.csv ] || fail "a refused command left poses"
}
