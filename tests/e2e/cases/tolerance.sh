# Cases of pickbed tolerance.

tolerance_map_resumes() {
  local few=(--set grasps=3 --set steps=2 --set step_mm=4 --set fit_samples=30 --set test_samples=30)
  local map=("$pickbed" tolerance rod jaw_8cm --pairs gx:gry "${few[@]}")
  expect 0 "${map[@]}" --jobs 1 --out one
  grep -q "along the closing direction" last.out || fail "no table of the axes"
  grep -q "^  mssd" last.out || fail "no table of the scores"
  for file in map.png pairs.png model.yaml tolerance.yaml; do
    [ -s "one/$file" ] || fail "no $file"
  done
  refused "--resume" "${map[@]}" --out one
  refused "other settings" "${map[@]}" --out one --resume --set seed=3
  mkdir two
  head -60 one/samples.csv >two/samples.csv
  expect 0 "${map[@]}" --jobs 2 --out two --resume
  for file in samples.csv axes.csv pairs.csv predictors.csv model.yaml; do
    same "one/$file" "two/$file"
  done
  brick 10 >wide.obj
  expect 0 "$pickbed" object add wide.obj --name wide --unit mm --mass 1
  refused "object 'wide' has no antipodal pair that fits its stroke for gripper 'jaw_8cm', but" "$pickbed" tolerance wide jaw_8cm --out wide
  [ ! -e wide ] || fail "a refused map left a folder"
  refused "did you mean 'gy'" "${map[@]}" --pairs gx:gyy --out three
  refused "axes of one frame" "${map[@]}" --pairs x:gx --out three
  refused "did you mean 'rod'" "$pickbed" tolerance rodd jaw_8cm
}

tolerance_maps_forecast_the_picks_of_a_run() {
  expect 0 "$pickbed" tolerance rod jaw_8cm --set grasps=3 --set steps=2 --set step_mm=4 \
    --set fit_samples=30 --set test_samples=30 --out maps/rod
  cp small.yaml here.yaml
  expect 0 "$pickbed" run here.yaml "${noisy[@]}" --tolerance maps --out one
  grep -q "^Picks of rod by their pose errors" last.out || fail "no forecast"
  grep -q '"pick_forecasts"' one/summary.json || fail "no forecast in summary.json"
  head -1 one/attempts.csv | grep -q ",p_pick," || fail "attempts.csv has no p_pick"
  [ "$(grep -c "^[01],[0-9]*,[0-9]*,rod,[0-9-]*,[01]\.[0-9]*$" one/pick_chances.csv)" -gt 3 ] ||
    fail "hypotheses have no pick probability"
  expect 0 "$pickbed" run here.yaml "${noisy[@]}" --tolerance maps/rod/model.yaml --out two --jobs 1
  for file in attempts.csv pick_chances.csv summary.json; do same "one/$file" "two/$file"; done
  cat >sweep.yaml <<'YAML'
scenario: here.yaml
trials: 1
set: {estimator.name: oracle}
grid:
  gripper: [jaw_8cm]
  cell.hand_eye_mm: [0, 4]
YAML
  expect 0 "$pickbed" sweep sweep.yaml --out swept
  expect 0 "$pickbed" report swept --tolerance maps --out forecast.html
  page forecast.html "Errors of the cell: "
  page forecast.html "forecast"
  expect 0 "$pickbed" budget one --stages none --tolerance maps
  page one/budget/index.html "Prediction of picks from pose errors"
  page one/budget/index.html "bins are too few"
  expect 0 "$pickbed" estimate here.yaml "${noisy[@]:0:4}" --trials 1 --tolerance maps --out poses
  head -1 poses/hypotheses.csv | grep -q ",p_pick," || fail "hypotheses.csv has no p_pick"
  refused "is a map of rod with jaw_8cm; the objects are rod, flange, the gripper is jaw_14cm" \
    "$pickbed" run here.yaml --set gripper=jaw_14cm --tolerance maps/rod --out no
  cp -r maps/rod maps/again
  refused "are both maps of rod with jaw_8cm" "$pickbed" run here.yaml --tolerance maps --out no
  refused "there is no such file" "$pickbed" run here.yaml --tolerance nowhere --out no
  refused "write ID=PLACE" "$pickbed" score --bop none none.csv --tolerance maps
}
