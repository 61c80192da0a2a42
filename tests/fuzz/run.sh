#!/bin/sh
# run.sh [SECONDS [FUZZER...]]: builds the fuzzers with clang and runs each (or those named) for that
# long, from good inputs that make_corpus writes and from its corpus, tests/fuzz/corpus/FUZZER. What it finds stays in build/fuzz/findings/FUZZER; new inputs that reach
# more code in build/fuzz/corpus/FUZZER. Ends with 1 if anything was found.
#
# CORBSLAM_FUZZ_BUILD: another folder than build/fuzz. CORBSLAM_FUZZ_RUNS: ends a fuzzer's run
# earlier, after so many executions.
set -eu

seconds=${1:-20}
[ $# -gt 0 ] && shift
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${CORBSLAM_FUZZ_BUILD:-$root/build/fuzz}
fuzzers=${*:-sync_fuzzer store_fuzzer work_fuzzer shared_update_fuzzer spool_fuzzer \
  dataset_fuzzer spec_fuzzer vocabulary_fuzzer}

cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER=clang++-14 -DCMAKE_C_COMPILER=clang-14 \
  -DCORBSLAM_BUILD_FUZZERS=ON -DCORBSLAM_BUILD_TESTS=OFF -DCORBSLAM_BUILD_BENCHMARKS=OFF >/dev/null
# shellcheck disable=SC2086
ninja -C "$build" make_corpus $fuzzers
"$build/bin/make_corpus" "$build/seeds"

found=0
for fuzzer in $fuzzers; do
  corpus=$build/corpus/$fuzzer
  findings=$build/findings/$fuzzer
  mkdir -p "$corpus" "$findings" "$root/tests/fuzz/corpus/$fuzzer"
  echo "== $fuzzer, $seconds s"
  runs=""
  [ -n "${CORBSLAM_FUZZ_RUNS:-}" ] && runs="-runs=$CORBSLAM_FUZZ_RUNS"
  GLOG_logtostderr=0 GLOG_minloglevel=3 \
    "$build/fuzz/$fuzzer" -max_total_time="$seconds" $runs -max_len=16384 -timeout=20 \
    -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="$findings/" \
    "$corpus" "$root/tests/fuzz/corpus/$fuzzer" "$build/seeds/$fuzzer" >"$findings/log" 2>&1 || {
    found=1
    echo "FOUND something: $findings"
  }
  grep -E "stat::number_of_executed_units|stat::average_exec_per_sec|SUMMARY|cov:" "$findings/log" |
    tail -n 4
done
exit $found
