# Cases of pickbed grasps and gripper.

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

  # Its narrowest side is 100 mm.
  brick 5 >big.obj
  expect 0 "$pickbed" object add big.obj --name big --unit mm --mass 0.5 --drops 5
  refused "object 'big' has no antipodal pair that fits its stroke for gripper 'jaw_8cm', but" \
    "$pickbed" grasps big jaw_8cm "${quick[@]}" --out none
  grep -q "jaw_14cm has [0-9]" last.err || fail "the wider jaw is not suggested"
  grep -q "has 20 grasps" last.err && fail "--count limits the grasps of other grippers"
  [ ! -e none ] || fail "a refused command left a folder"
  refused "did you mean 'carton'" "$pickbed" grasps cartn jaw_8cm
  refused "unknown gripper 'claw'" "$pickbed" grasps carton claw
  refused "robust.samples" "$pickbed" grasps carton jaw_8cm --set robust.samples=0
  refused "cannot write 'newdir/a.yaml'" "$pickbed" grasps carton jaw_8cm --write newdir/a.yaml --out none
  refused "ends in .yaml (isaac_grasp) or .csv" "$pickbed" grasps carton jaw_8cm --write a.txt --out none
  [ ! -e none ] || fail "the place of --write is checked after the work"
}

grasps_of_a_file_are_tested() {
  local quick=(--count 8 --set antipodal.max_pairs=80 --set robust.samples=4)
  local test=(--set bins=1 --set instances=3 --set hold.max_g=3)
  expect 0 "$pickbed" grasps rod jaw_8cm "${quick[@]}" --write rod.yaml --out made
  expect 0 "$pickbed" grasps rod jaw_8cm --from rod.yaml --write rod.csv "${test[@]}" --jobs 2 --out tested
  [ "$(wc -l <tested/grasp_tests.csv)" = 9 ] || fail "not 8 tests"
  grep -q "^on a table .* succeed" last.out || fail "no rate on the table"
  grep -q "^in 1 bins of 3" last.out || fail "no rate in bins"
  expect 0 "$pickbed" grasps rod jaw_8cm --from rod.csv "${test[@]}" --jobs 1 --out again
  cut -d, -f3- tested/grasp_tests.csv >a.csv
  cut -d, -f3- again/grasp_tests.csv >b.csv
  same a.csv b.csv
  expect 0 "$pickbed" grasps rod jaw_8cm --from rod.yaml --frame tips --write panda.csv "${test[@]}" --set max_grasps=1 --out one
  same rod.csv panda.csv

  refused "is for the gripper jaw_8cm.yaml, not jaw_14cm" "$pickbed" grasps rod jaw_14cm --from rod.yaml
  grep -q -- "--ignore-names" last.err || fail "no remedy"
  refused "is for the object rod.obj, not flange" "$pickbed" grasps flange jaw_8cm --from rod.yaml
  refused "unknown object 'rd'; did you mean 'rod'" "$pickbed" grasps rd jaw_8cm --from rod.yaml
  sed 's/format_version: 1.0/format_version: 2.0/' rod.yaml >later.yaml
  refused "format_version = '2.0': this pickbed reads 1.0" "$pickbed" grasps rod jaw_8cm --from later.yaml
  sed 's/w: [-0-9.e]*/w: 3/' rod.yaml >long.yaml
  refused "must be a unit quaternion" "$pickbed" grasps rod jaw_8cm --from long.yaml
  sed '/^grasps:/q' rod.yaml >empty.yaml
  refused "has no grasps" "$pickbed" grasps rod jaw_8cm --from empty.yaml
  sed 's/object_scale: 1.0/object_scale: 0.5/' rod.yaml >scaled.yaml
  refused "object_scale = 0.5: must be 1" "$pickbed" grasps rod jaw_8cm --from scaled.yaml
  sed 's/left_finger: [-0-9.e]*/left_finger: 0.3/' rod.yaml >wide.yaml
  refused "but gripper jaw_8cm opens at most 0.08 m" "$pickbed" grasps rod jaw_8cm --from wide.yaml
  refused "cannot write 'newdir/a.csv'" "$pickbed" grasps rod jaw_8cm --from rod.yaml --write newdir/a.csv --out unmade
  [ ! -e unmade ] || fail "the place of --write is checked after the work"
  refused "unknown gripper frame 'panda'" "$pickbed" grasps rod jaw_8cm --from rod.yaml --frame panda
}

grippers_are_drawn() {
  for gripper in jaw_4cm jaw_8cm jaw_14cm cup_30mm; do
    expect 0 "$pickbed" gripper show "$gripper"
    [ -s "results/gripper_$gripper.png" ] || fail "no picture of $gripper"
  done
  grep -q "vacuum_n: 45" last.out || fail "the force of the cup is not printed"
  printf 'mechanism: suction_cup\nvacuum_n: 0\n' >weak.yaml
  expect 1 "$pickbed" gripper show weak.yaml
  grep -q "weak.yaml:2: vacuum_n = 0" last.err || fail "a cup without force is not refused"
}
