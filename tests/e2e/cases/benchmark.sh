# Cases of pickbed benchmark.

crop_benchmark_is_repeatable() {
  local few=(bracket mug --small --method wohlhart,hog,random --condition clean,noisy
    --set tests=4 --set icp_starts=1 --set views.template_level=1 --set views.train_level=2
    --set methods.wohlhart.iterations=6 --set methods.wohlhart.mine_every=6
    --set methods.wohlhart.anchors=8)
  expect 0 "$pickbed" benchmark crops "${few[@]}" --threads 1 --out once
  expect 0 "$pickbed" benchmark crops "${few[@]}" --threads 2 --out twice
  for file in crops.csv views.csv differences.csv settings.yaml; do
    same once/$file twice/$file
  done
  # Trained models are kept: a second call is quick and gives the same table.
  cp once/views.csv before.csv
  expect 0 "$pickbed" benchmark crops "${few[@]}" --out once
  same once/views.csv before.csv
  page once/crops.html wohlhart
  expect 0 "$pickbed" benchmark crops "${few[@]}" --set seed=1 --out other
  cmp -s once/views.csv other/views.csv && fail "another seed gives the same results"
  refused "unknown crop method 'hogg'" "$pickbed" benchmark crops --small --method hogg
  refused "methods.wohlhart.descriptor" \
    "$pickbed" benchmark crops --small --set methods.wohlhart.descriptor=1
}

bin_benchmark_trains_missing_models() {
  local few=(rods.yaml --small --scenes 1 --estimator "wohlhart;oracle" --out bins)
  # This replaces the training of --small, which takes minutes.
  expect 0 "$pickbed" train wohlhart rod --out bins/models/wohlhart.net --set clutter_scenes=2 \
    --set wohlhart.views.templates.template_level=1 --set wohlhart.views.templates.in_plane=12 \
    --set wohlhart.views.isolated=100 --set wohlhart.views.clutter_scenes=2 \
    --set wohlhart.network.iterations=4 --set wohlhart.network.mine_every=4
  expect 0 "$pickbed" benchmark bins "${few[@]}"
  grep -q '^all,"wohlhart",1,' bins/bins.csv || fail "no row of wohlhart for all"
  grep -q '^all,"oracle",1,' bins/bins.csv || fail "no row of the oracle for all"
  page bins/bins.html wohlhart
  cp bins/bins.csv before.csv
  # Results are kept: a second call gives the same table without new images.
  expect 0 "$pickbed" benchmark bins "${few[@]}"
  same bins/bins.csv before.csv
  refused "unknown estimator 'wohlhat'" "$pickbed" benchmark bins rods.yaml --estimator wohlhat
  refused "wohlhart.neighbors" "$pickbed" train wohlhart rod --set wohlhart.neighbors=0
  refused "wohlhart.network.margin" "$pickbed" train wohlhart rod --set wohlhart.network.margin=0
  refused "leave it at depth" "$pickbed" train wohlhart rod --set wohlhart.network.input=rgb
}

benchmark_all_checks_its_input_and_stops_on_interrupt() {
  refused "'nix.obj'" "$pickbed" benchmark all --mesh nix.obj --out both
  [ ! -e both ] || fail "the bin benchmark started before the meshes were checked"
  refused "--unit requires --mesh" "$pickbed" benchmark all --unit mm --out both
  refused "--small excludes --mesh" "$pickbed" benchmark all --small --mesh nix.obj
  "$pickbed" benchmark all --small --out both >stopped.out 2>stopped.err &
  local pid=$!
  while kill -0 $pid 2>/dev/null && ! grep -q "^network" stopped.err; do sleep 0.1; done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "the exit status is not 130"
  grep -q "to continue with this training" stopped.err || fail "no message how to continue"
  [ -n "$(ls both/bins/models/kehl-*.net.checkpoint)" ] || fail "no checkpoint of the training"
  [ ! -e both/crops ] || fail "the crop benchmark started after the interrupt"
}

# Rooms depend on the seed only, and invalid input is refused before rendering.
rooms_benchmark_is_repeatable() {
  local few=(rod --estimator descriptor:fast --bins 1 --tables 0 --empty 1)
  expect 0 "$pickbed" benchmark rooms "${few[@]}" --threads 1 --out once
  expect 0 "$pickbed" benchmark rooms "${few[@]}" --threads 2 --out twice
  same once/rooms.csv twice/rooms.csv
  same once/room_poses.csv twice/room_poses.csv
  grep -q '^empty,all,1,0,0,' once/rooms.csv || fail "no row of the room without objects"
  grep -q '^all,given,2,' once/rooms.csv || fail "no row of given bins"
  refused "unknown estimator 'discriptor'" "$pickbed" benchmark rooms rod --estimator discriptor
  refused "no objects" "$pickbed" benchmark rooms
}
