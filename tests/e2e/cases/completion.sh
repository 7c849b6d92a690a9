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

  local few=(--small --sets unseen_families,ycb --methods network,skirt)
  expect 0 "$pickbed" benchmark completion "${few[@]}" --model "$work/whole.net" --out table
  grep -q "set ycb is skipped" last.out || fail "the missing data is not reported"
  page table/index.html "Calibration of network"
  head -c 1000 whole.net >short.net
  refused "short.net: the file is cut short" "$pickbed" benchmark completion "${few[@]}" --model "$work/short.net"
  refused "did you mean 'skirt'" "$pickbed" benchmark completion --small --methods skrit
  local later=(--small --sets catalog --methods skirt --out later)
  refused "unknown planner 'skrit'" "$pickbed" benchmark completion "${later[@]}" --tables shapes,grasp --planners skrit
  refused "unknown completion method 'skrit'" "$pickbed" benchmark completion "${later[@]}" \
    --tables shapes,recognition --completions none,skrit
  [ ! -e later ] || fail "the first tables were made before the options of the later ones were read"
}
