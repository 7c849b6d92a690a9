# Cases of pickbed doctor.

doctor_reports_no_fault() {
  expect 0 "$pickbed" doctor
  [ "$(grep -c '^ok' last.out)" = 5 ] || fail "not all checks are ok"
}
