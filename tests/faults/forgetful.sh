#!/bin/sh
# A planted fault: pickbed that removes the finished trials before it resumes.
case " $* " in *" --resume "*) rm -f out/results.sqlite ;; esac
exec "$PICKBED" "$@"
