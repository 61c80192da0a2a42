#!/bin/sh
# run.sh [SECONDS [FUZZER...]]: builds the fuzzers with clang and runs each (or those named) for that
# long, as many at a time as there are processors, from good inputs that make_corpus writes and from
# its corpus, tests/fuzz/corpus/FUZZER. What it finds stays in build/fuzz/findings/FUZZER; new inputs
# that reach more code in build/fuzz/corpus/FUZZER. Ends with 1 if anything was found.
#
# CORBSLAM_FUZZ_BUILD: another folder than build/fuzz. CORBSLAM_FUZZ_RUNS: ends a fuzzer's run
# earlier, after so many executions. CORBSLAM_FUZZ_SEED: the same inputs each time.
set -eu

seconds=${1:-20}
[ $# -gt 0 ] && shift
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
build=${CORBSLAM_FUZZ_BUILD:-$root/build/fuzz}
fuzzers=${*:-sync_fuzzer store_fuzzer journal_fuzzer work_fuzzer shared_update_fuzzer spool_fuzzer \
  feature_coding_fuzzer dataset_fuzzer bag_fuzzer rig_fuzzer spec_fuzzer vocabulary_fuzzer config_fuzzer name_fuzzer token_fuzzer}

"$root/deploy/install_packages.sh" packages_fuzz.txt
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER=clang++-14 -DCMAKE_C_COMPILER=clang-14 \
  -DCORBSLAM_BUILD_FUZZERS=ON -DCORBSLAM_BUILD_TESTS=OFF -DCORBSLAM_BUILD_BENCHMARKS=OFF >/dev/null
# shellcheck disable=SC2086
ninja -C "$build" make_corpus $fuzzers
"$build/bin/make_corpus" "$build/seeds"
# shellcheck disable=SC2086
printf '%s\n' $fuzzers | xargs -n 1 -P "$(nproc)" "$here/run_one.sh" "$build" "$seconds"
