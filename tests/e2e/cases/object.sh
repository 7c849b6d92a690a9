# Cases of pickbed object, drop and render.

drop_and_render_write_their_files() {
  expect 0 "$pickbed" drop small.yaml --out drop
  [ "$(grep -c '"instance"' drop/scene.json)" = 5 ] || fail "scene.json does not have 5 instances"
  [ -s drop/color.png ] || fail "no picture"
  refused "gripper" "$pickbed" drop small.yaml --set gripper=nonsense --out no
  [ ! -e no ] || fail "a refused gripper left a folder"
  expect 0 "$pickbed" drop small.yaml --set camera.focal_px=60 --out small
  grep -q "^note: .* px large .* an estimator needs 20 px" last.err || fail "no note on the size"
  expect 0 "$pickbed" render small.yaml --out render
  for file in color.png depth.png depth_color.png ids.png ids_color.png visible.csv; do
    [ -s "render/$file" ] || fail "no $file"
  done
  [ "$(wc -l <render/visible.csv)" = 6 ] || fail "visible.csv does not have 5 instances"
}

an_added_object_can_be_dropped_and_picked() {
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
  grep -q "nothing to do" last.out || fail "the object was made twice"
  refused "--name ''" "$pickbed" object add brick.obj --name ''
  refused "is no file" "$pickbed" object add /dev/zero --name zero
  refused "--mass nan" "$pickbed" object add brick.obj --name heavy --mass nan
  expect 1 "$pickbed" object add brick.obj --name brick --mass 0.06
  grep -q -- "--replace" last.err || fail "an existing object is not reported"
  echo "objects: [{name: brick, count: 4}]" >bricks.yaml
  expect 0 "$pickbed" run bricks.yaml "${small[@]}" --trials 1 --out bricks
  grep -q '"instances_cleared": 4' bricks/summary.json || fail "the bricks were not picked"
}

sampled_shapes_are_objects() {
  local sample=("$pickbed" object sample)
  expect 0 "${sample[@]}" ring --seed 3 --out sampled
  for file in mesh.obj convex.obj object.yaml; do
    [ -s "sampled/ring_3/$file" ] || fail "no $file"
  done
  expect 0 "${sample[@]}" ring --seed 3 --out again
  diff -r sampled again || fail "the same seed gave other bytes"
  expect 0 "${sample[@]}" --domain machine --split unseen_families --seed 2 --out sampled
  echo "objects: [{name: ring_3, count: 2}, {name: sampled/tube/outside/1, count: 2}]" >sampled.yaml
  expect 0 "$pickbed" drop sampled.yaml --catalog sampled --out sampled_drop
  [ "$(grep -c '"instance"' sampled_drop/scene.json)" = 4 ] || fail "not 4 instances"
  refused "did you mean 'ring'" "${sample[@]}" rinq --out x
  refused "did you mean 'outside'" "${sample[@]}" ring --split outsid --out x
  refused "not both" "${sample[@]}" ring --domain machine --out x
  refused "or --domain" "${sample[@]}" --out x
  refused "did you mean 'machine'" "${sample[@]}" --domain machin --out x
  refused "--count" "${sample[@]}" ring --count 0 --out x
  refused "needs a domain" "${sample[@]}" ring --split unseen_families --out x
  refused "--seed" "${sample[@]}" ring --seed -1 --out x
}

families_are_drawn_on_one_sheet() {
  expect 0 "$pickbed" object families --seed 1 --out sheet.png
  [ "$(head -c 4 sheet.png | tail -c 3)" = PNG ] || fail "no picture"
  expect 0 "$pickbed" object families --seed 1 --out again.png
  same sheet.png again.png
  expect 0 "$pickbed" object families --seed 2 --out other.png
  ! cmp -s sheet.png other.png || fail "another seed gave the same shapes"
}

invalid_meshes_are_refused() {
  local add=("$pickbed" object add) name=(--name x --drops 5)
  brick 1 | sed 's/^v 30 20 10$/v nan 20 10/' >nan.obj
  refused "nan.obj' has vertices that are not numbers" "${add[@]}" nan.obj "${name[@]}"
  { brick 1 | grep -v '^f'; echo 'f 1 2 3'; } >one.obj
  refused "one.obj' encloses no volume" "${add[@]}" one.obj "${name[@]}"
  brick 1 | sed 's/10$/0/' >flat.obj
  refused "flat.obj' encloses no volume" "${add[@]}" flat.obj "${name[@]}"
  brick 20000 >vast.obj
  refused "check the unit" "${add[@]}" vast.obj "${name[@]}"
  brick 1 >brick.stl
  refused "its extension matches its format" "${add[@]}" brick.stl "${name[@]}"
  refused "nowhere.obj" "${add[@]}" nowhere.obj "${name[@]}"
  { # The header declares 5 million faces; the rest of the file is not read.
    printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n'
    printf 'property float z\nelement face 5000000\nproperty list uchar int vertex_indices\n'
    printf 'end_header\n'
  } >many.ply
  refused "many.ply' has 5000000 faces; reduce it to 1000000" "${add[@]}" many.ply "${name[@]}"
  [ ! -e objects/x ] || fail "a refused mesh left an object"

  # Files that are missing next to a mesh are reported, and the object is made.
  { echo "mtllib gone.mtl"; brick 1; } >plain.obj
  expect 0 "${add[@]}" plain.obj --name plain --drops 5
  grep -q "'gone.mtl' is missing" last.out || fail "the missing .mtl is not named"
  printf 'newmtl a\nmap_Kd gone.png\n' >there.mtl
  { echo "mtllib there.mtl"; brick 1; } >bare.obj
  expect 0 "${add[@]}" bare.obj --name bare --drops 5
  grep -q "'gone.png' is missing" last.out || fail "the missing texture is not named"
}

invalid_scenes_are_refused() {
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
