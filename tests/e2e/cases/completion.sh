# Cases of pickbed train completion and pickbed benchmark completion.

completion_training_resumes_after_a_kill() {
  local quick=(--domain machine --sensor ideal,structured_light --set steps=40 --set batch=2 --set window=3
    --set held_out=2 --set measure_every=20 --set checkpoint_every=5 --set points=64 --set views.max_diameter_px=50
    --set network.width_16=4 --set network.width_8=4 --set network.width_4=4 --set network.bottleneck=4)
  "$pickbed" train completion "${quick[@]}" --out killed.net 2>killed.err &
  local pid=$!
  while kill -0 $pid 2>/dev/null && [ ! -s killed.net.checkpoint ]; do sleep 0.02; done
  kill -KILL $pid 2>/dev/null
  wait $pid
  [ ! -e killed.net ] || fail "the training ended before it was killed"
  expect 0 "$pickbed" train completion "${quick[@]}" --out killed.net --resume
  page killed_report/index.html "Unseen families"
  [ ! -e killed.net.checkpoint ] || fail "the checkpoint of a finished training is left over"
  expect 0 "$pickbed" train completion "${quick[@]}" --out whole.net --threads 2
  same killed.net whole.net
  same killed_report/completion_curves.csv whole_report/completion_curves.csv
  refused "no whole.net.checkpoint to resume from" "$pickbed" train completion --resume --out whole.net
  refused "did you mean 'machine'" "$pickbed" train completion --domain machin --out other.net

  refused "machine is given twice" "$pickbed" train completion --domain machine,machine --out other.net

  local few=(--small --tables shapes --sets unseen_families,ycb --methods network,skirt)
  expect 0 "$pickbed" benchmark completion "${few[@]}" --model "$work/whole.net" --out table
  grep -q "set ycb is skipped" last.out || fail "the missing data is not reported"
  page table/index.html "Calibration of network"
  head -c 1000 whole.net >short.net
  refused "short.net: the file is cut short" "$pickbed" benchmark completion "${few[@]}" --model "$work/short.net"
  refused "did you mean 'skirt'" "$pickbed" benchmark completion --small --tables shapes --methods skrit
  local later=(--small --sets catalog --methods skirt --out later)
  refused "unknown planner 'skrit'" "$pickbed" benchmark completion "${later[@]}" --tables shapes,grasp --planners skrit
  refused "unknown completion method 'skrit'" "$pickbed" benchmark completion "${later[@]}" \
    --tables shapes,recognition --completions none,skrit
  [ ! -e later ] || fail "the first tables were made before the options of the later ones were read"
}

# By default, all tables and their galleries are on one page.
completion_benchmark_has_all_tables_on_one_page() {
  expect 0 "$pickbed" benchmark completion --small --sets catalog --methods network,skirt --single-drops 1 \
    --completions none,skirt --mode fast --out all
  for heading in "Chamfer" "Calibration of network" "Gallery of network" "Grasps of unknown objects" \
    "Gallery of grasps" "Recognition of known objects" "Gallery of recognition"; do
    page all/index.html "$heading"
  done
  [ "$(wc -l <all/completion_grasps.csv)" = 5 ] || fail "not one line per condition and planner"
  [ "$(wc -l <all/recognition.csv)" -gt 5 ] || fail "no recall by visible fraction"
  local picture
  for picture in all/gallery_catalog.png all/gallery_grasps_single_completed.png \
    all/gallery_grasps_bins_completed.png \
    all/recognition/deep_rod_0_000/pictures/trial_0000/{none,skirt}/attempt_00_overlay.png; do
    [ -s "$picture" ] || fail "no $picture"
    has_template || continue
    grep -qF "src=\"${picture#all/}\"" all/index.html || fail "$picture is not on the page"
  done
  grep -q "table grasp, 2 of 3" last.err || fail "the progress does not name the table"
}

# What is done is on the page when the benchmark is stopped.
completion_benchmark_keeps_what_is_done() {
  "$pickbed" benchmark completion --small --sets catalog --methods skirt --planners skirt \
    --single-drops 500 --out kept >last.out 2>last.err &
  local pid=$!
  for _ in $(seq 600); do
    grep -q "^trial [1-9]" last.err && break
    sleep 0.2
  done
  kill -INT $pid
  wait $pid
  [ $? = 130 ] || fail "the exit status is not 130"
  [ -s kept/completion.csv ] || fail "the first table is lost"
  page kept/index.html "Grasps of unknown objects"
  page kept/index.html "The benchmark was stopped here."
  [ "$(wc -l <kept/completion_grasps_shapes.csv)" -gt 1 ] || fail "the finished drops are lost"
  [ ! -e kept/recognition.csv ] || fail "a table was begun after the interrupt"
}
