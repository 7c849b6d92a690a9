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
  grep -q "cup_30mm has 20" last.err || fail "the suction cup is not suggested"
  [ ! -e none ] || fail "a refused command left a folder"
  refused "did you mean 'carton'" "$pickbed" grasps cartn jaw_8cm
  refused "unknown gripper 'claw'" "$pickbed" grasps carton claw
  refused "robust.samples" "$pickbed" grasps carton jaw_8cm --set robust.samples=0
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
