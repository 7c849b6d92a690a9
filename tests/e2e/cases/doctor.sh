# Cases of pickbed doctor.

doctor_reports_no_fault() {
  expect 0 "$pickbed" doctor
  [ "$(grep '^ok' last.out | grep -vc '^ok *python ')" = 5 ] || fail "not all checks are ok"
  if [ -d "$(dirname "$pickbed")/python" ]; then
    grep -q "^ok *python *pickbed [0-9.]* in .*/pickbed\..*so$" last.out || fail "the Python module is not found"
  else
    grep -q "^none *python" last.out || fail "the Python module is not built, but found"
  fi
}
