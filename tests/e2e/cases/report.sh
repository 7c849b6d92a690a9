# Cases of pickbed report and pickbed compare, in a browser.

# Skips a case if the program was built without its report page, as without access to the npm registry.
_needs_report_page() {
  has_template || { echo "skipped: the report page was not built, see the output of the build"; exit 77; }
}

# _browser PAGE VIEWS PICKS: fails unless the page works in Chromium and has that many 3D views and
# animated picks.
_browser() {
  node "$here/report_check.mjs" "$1" --views "$2" --picks "$3" >browser.out 2>browser.err ||
    fail "$1 does not work in a browser"
  [ "$(stat -c %s "$1")" -lt 15000000 ] || fail "$1 is too large"
}

reports_work_in_a_browser() {
  _needs_report_page
  local one=(--set policy.stop=one_pick --trials 12 --set estimator.name=oracle)
  expect 0 "$pickbed" run small.yaml "${one[@]}" --set estimator.noise_mm=9 --out one
  expect 0 "$pickbed" run small.yaml "${one[@]}" --set estimator.noise_mm=3 --out two
  local few=(--views 2 --animations 2) # each takes seconds in the browser
  expect 0 "$pickbed" report one "${few[@]}"
  grep -q "one/report.html" last.out || fail "the page is not named"
  _browser one/report.html 2 2
  grep -q "data:image/jpeg" one/report.html || fail "no picture of a failed pick"
  grep -q "have no picture here" one/report.html && fail "a failed pick has no picture"
  expect 0 "$pickbed" report one "${few[@]}" --out one/again.html
  same one/report.html one/again.html
  expect 0 "$pickbed" compare one two "${few[@]}" --out both.html --json both.json
  grep -q "^A is one, B is two; 12 scenes that both have" last.out || fail "the shared bins are not reported"
  grep -q "^  pick success, % .*\[.*\]" last.out || fail "the differences are not printed"
  grep -q '"first": "one"' both.json && grep -q '"odds_ratio_ci95"' both.json &&
    grep -q '"scenes_needed"' both.json || fail "the differences are not in the JSON file"
  _browser both.html 2 2
  expect 0 "$pickbed" report two --views 0 --animations 0 --out flat.html
  _browser flat.html 0 0
  [ "$(stat -c %s flat.html)" -lt 1200000 ] || fail "a page without 3D views holds their library"
}

# The name of a run is on its page, and the names of both on the page of a comparison.
markup_in_names_is_shown_as_text() {
  _needs_report_page
  local run='<img src=x onerror=window.injected=1>' object='<script>self["injected"]=1<script>'
  mkdir objects
  cp -r "$here/../../assets/objects/rod" "objects/$object"
  cat >markup.yaml <<YAML
objects: [{name: '$object', count: 3}]
estimator: {name: oracle, noise_mm: 9}
policy: {stop: one_pick}
YAML
  expect 0 "$pickbed" run markup.yaml --trials 6 --out "$run"
  expect 0 "$pickbed" run markup.yaml --trials 6 --set estimator.noise_mm=3 --out two
  local few=(--views 1 --animations 1) # each takes seconds in the browser
  expect 0 "$pickbed" report "$run" "${few[@]}" --out page.html
  expect 0 "$pickbed" compare "$run" two "${few[@]}" --out both.html
  for page in page.html both.html; do
    grep -q "&lt;img src=x" $page || fail "the run is not named on $page"
    grep -q "&lt;script&gt;self" $page || fail "the object is not named on $page"
    grep -qE "<img src=x|<script>self" $page && fail "$page contains the markup of a name"
    _browser $page 1 1
  done
}

invalid_report_requests_are_refused() {
  _needs_report_page
  refused "nowhere" "$pickbed" report nowhere
  mkdir empty
  refused "empty" "$pickbed" report empty
  echo "no database" >empty/results.sqlite
  refused "results.sqlite" "$pickbed" report empty
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --pictures 0 --out one
  refused "is a folder" "$pickbed" report one --out .
  refused "named twice" "$pickbed" compare one one --out both.html
  expect 0 "$pickbed" run small.yaml "${small[@]}" --trials 1 --pictures 0 --set seed=8 --out other
  refused "seed" "$pickbed" compare one other --out both.html
  [ ! -e both.html ] || fail "a refused comparison left a page"
  [ ! -e one/report.html ] || fail "a refused report left a page"
}
