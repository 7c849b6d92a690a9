# Cases of pickbed train.

training_resumes_after_an_interrupt() {
  local quick=(--set clutter_scenes=2 --set views_per_scene=1 --set iterations=80 --set batch=64
    --set checkpoint_every=5 --set held_out.clutter_scenes=1 --set held_out.book_views=20
    --set held_out.queries=50 --set held_out.every=40 --set verifier_clutter_scenes=2 --set verifier_room_scenes=2
    --set verifier_entries=1000 --set verifier.iterations=100 --set candidates.points=300
    --set candidates.min_points=100 --set candidates.candidates=100)
  local short=(rod "${quick[@]}")
  "$pickbed" train "${short[@]}" --out rod.net 2>stopped.err &
  local pid=$!
  while kill -0 $pid 2>/dev/null && ! grep -q "^network" stopped.err; do sleep 0.1; done
  kill -INT $pid 2>/dev/null
  wait $pid
  local rc=$?
  [ $rc = 130 ] || fail "the exit status is $rc, not 130"
  [ -s rod.net.checkpoint ] || fail "no checkpoint"
  [ ! -e rod.net ] || fail "an unfinished model was written"
  cp rod.net.checkpoint good.checkpoint
  (
    trap '' XFSZ # a write beyond the limit then fails and does not kill
    ulimit -f 100
    "$pickbed" train "${short[@]}" --out rod.net --resume 2>last.err
  )
  [ $? = 1 ] || fail "a full disk did not end the training"
  grep -q "^pickbed: .*rod.net.checkpoint" last.err || fail "the checkpoint on a full disk is not named"
  same rod.net.checkpoint good.checkpoint
  expect 0 "$pickbed" train "${short[@]}" --out rod.net --resume
  page rod_report/index.html Held-out
  for file in embedding.png answers.png pairs.png curves.csv timings.csv; do
    [ -s "rod_report/$file" ] || fail "no $file in the report"
  done
  expect 0 "$pickbed" train "${short[@]}" --out unstopped.net
  cmp rod.net unstopped.net || fail "a stopped and resumed training gives other weights"
  same rod_report/curves.csv unstopped_report/curves.csv
  expect 0 "$pickbed" estimate rods.yaml --out look --set "estimator.model=$work/rod.net"
  refused "rod.net: not trained for object 'flange' (knows rod)" \
    "$pickbed" estimate small.yaml --out look --set "estimator.model=$work/rod.net"

  # Adds an object to the known one.
  expect 0 "$pickbed" train flange --from rod.net "${quick[@]}" --out both.net --report page \
    --sensor structured_light,time_of_flight
  page page/index.html "structured_light, time_of_flight"
  grep -q "rod, known from the start model: recall@1" last.out || fail "the object of the start model is not reported"
  [ -s page/curves.csv ] || fail "no report in the requested folder"
  [ ! -e both.net.checkpoint ] || fail "the checkpoint of a finished training is left over"
  expect 0 "$pickbed" estimate small.yaml --out look --set "estimator.model=$work/both.net"

  # A network for unknown backgrounds from both objects.
  expect 0 "$pickbed" train verifier --from both.net "${quick[@]}" --out whole.net
  "$pickbed" train verifier --from both.net "${quick[@]}" --out rooms.net 2>stopped.err >/dev/null &
  pid=$!
  while kill -0 $pid 2>/dev/null && ! grep -q "^object 2/2" stopped.err; do sleep 0.1; done
  kill -INT $pid 2>/dev/null
  wait $pid
  rc=$?
  [ $rc = 130 ] || fail "the exit status is $rc, not 130"
  grep -q "rooms.net.checkpoint keeps the candidates of 1 object;" stopped.err || fail "it is not said what is kept"
  expect 0 "$pickbed" train verifier --from both.net "${quick[@]}" --out rooms.net --resume
  cmp rooms.net whole.net || fail "a stopped and resumed training gives another verifier"
  expect 0 "$pickbed" train rod "${quick[@]}" --set shared_verifier=rooms.net --out shared.net

  # The same name with another mesh.
  brick 1 >brick.obj
  expect 0 "$pickbed" object add brick.obj --name rod --mass 0.1 --drops 5
  refused "rod.net: the mesh of object 'rod' has changed since training" \
    "$pickbed" estimate rods.yaml --out look --set "estimator.model=$work/rod.net"
  refused "rod.net: the mesh of object 'rod' has changed since training; name the object" \
    "$pickbed" train flange --from rod.net "${quick[@]}" --out both.net
}

invalid_training_requests_are_refused() {
  refused "no objects to train for" "$pickbed" train
  refused "takes neither --minutes nor --from" "$pickbed" train wohlhart rod --minutes 3
  refused "--verifier-for ppf trains the verifiers of another estimator" \
    "$pickbed" train kehl rod --verifier-for ppf
  refused "unknown key 'wohlhart'" "$pickbed" train rod --verifier-for ppf --set wohlhart.grid_px=3
  refused "missing.net: there is no such trained model" "$pickbed" train rod --from missing.net
  head -c 1000 /dev/urandom >broken.net
  refused "broken.net" "$pickbed" train rod --from broken.net
  refused "did you mean 'rod'" "$pickbed" train rodd
  refused "--groups: Value 3 not in range" "$pickbed" train grasps --groups 3 --data examples --out grasps.net
  refused "no models/rooms.net.checkpoint to resume" "$pickbed" train verifier --resume
  refused "there is no such trained model" "$pickbed" train verifier --from missing.net
  refused "rooms.net: the shared verifier does not exist" \
    "$pickbed" train rod --set shared_verifier=./rooms.net --out new.net
  refused "unknown key 'grids'" "$pickbed" train grasps --set grids=3 --out grasps.net
  refused "unknown sensor 'sonar'" "$pickbed" train rod --sensor sonar
  refused "no new.net.checkpoint to resume" "$pickbed" train rod --out new.net --resume
  echo checkpoint >new.net.checkpoint # of a network; the verifiers of ppf have none
  refused "no new.net.part to resume" \
    "$pickbed" train rod --verifier-for ppf --out new.net --resume
  [ -s new.net.checkpoint ] || fail "the checkpoint of another training was removed"
  rm new.net.checkpoint
  refused "no report page" "$pickbed" train wohlhart rod --report page
  refused "PICKBED_DEVICE is 'gpu'" env PICKBED_DEVICE=gpu "$pickbed" train rod --out new.net
  brick 1 | awk '/^v/ {print "v", $2 / 10, $3 / 10, $4 / 10; next} {print}' >speck.obj
  echo "objects: [{name: speck, mesh: speck.obj, unit: mm, mass_kg: 0.01, count: 3}]" >specks.yaml
  refused "object 'speck' is" "$pickbed" train --scenario specks.yaml --out specks.net
  grep -q "at least 10 px" last.err || fail "the minimum size is not reported"
  grep -q "^views" last.err && fail "it was reported only after views were rendered"
  echo "objects: []" >none.yaml
  refused "none.yaml" "$pickbed" train --scenario none.yaml
}
