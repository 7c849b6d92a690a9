# Results are the same on every x86-64 CPU. Variables of the libraries select the code that other CPUs
# run. Each run makes its own code book, since its bytes come from the network.

# _portable NAME VARIABLE=VALUE...: a bin with the network, and the network for unknown parts. Prints
# the hash of all results without times.
_portable() {
  local out=$1
  shift
  env "$@" XDG_CACHE_HOME="$work/cache_$out" "$pickbed" run portable.yaml --pictures 0 --failure-pictures 0 \
    --out "$out" >last.out 2>last.err || fail "the run under $* failed"
  env "$@" XDG_CACHE_HOME="$work/cache_$out" "$pickbed" run portable_unknown.yaml --pictures 0 \
    --failure-pictures 0 --out "$out/unknown" >last.out 2>last.err || fail "the run under $* failed"
  (cd "$out" && sha256sum {.,unknown}/{trials,attempts,instances}.csv "$work/cache_$out"/pickbed/codes-*.bin |
    cut -d' ' -f1 | sha256sum | cut -c1-16)
}

# It takes some 30 s, because three code books are made.
results_do_not_depend_on_the_cpu() {
  cat >portable.yaml <<'YAML'
seed: 11
trials: 1
objects: [{name: rod, count: 6}]
estimator: {name: descriptor, mode: fast}
policy: {max_attempts: 2}
YAML
  cat >portable_unknown.yaml <<'YAML'
seed: 11
trials: 1
objects: [{name: rod, count: 4}]
planner: {name: completed}
policy: {max_attempts: 1}
YAML
  local plain=$(_portable plain PORTABLE=1)
  local old=$(_portable old OPENBLAS_CORETYPE=Prescott DNNL_MAX_CPU_ISA=SSE41 ATEN_CPU_CAPABILITY=default \
    OPENCV_CPU_DISABLE=AVX512-SKX,AVX2,FMA3,AVX,FP16,SSE4.2,SSE4.1)
  local haswell=$(_portable haswell OPENBLAS_CORETYPE=Haswell DNNL_MAX_CPU_ISA=AVX2 ATEN_CPU_CAPABILITY=avx2)
  [ "$plain" = "$old" ] || fail "results differ from a CPU without AVX: $plain, $old"
  [ "$plain" = "$haswell" ] || fail "results differ from a CPU without AVX-512: $plain, $haswell"
  # Update it together with a change of results. Another value on another machine is a fault.
  [ "$plain" = 14cd1a284856a1bf ] || fail "the hash of the results is $plain"
}
