# Cases of pickbed doctor.

doctor_finds_nothing() {
  expect 0 "$pickbed" doctor
  [ "$(grep -c '^ok' last.out)" = 5 ] || fail "not all are ok"
}
