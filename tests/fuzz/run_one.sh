#!/bin/sh
# run_one.sh BUILD SECONDS FUZZER: run.sh's part for one fuzzer that is built.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
build=$1
seconds=$2
fuzzer=$3
corpus=$build/corpus/$fuzzer
# make_corpus writes none for a fuzzer that starts from its corpus alone.
seeds=$build/seeds/$fuzzer
findings=$build/findings/$fuzzer
runs=
[ -n "${CORBSLAM_FUZZ_RUNS:-}" ] && runs="-runs=$CORBSLAM_FUZZ_RUNS"
mkdir -p "$corpus" "$seeds" "$findings" "$here/corpus/$fuzzer"

# What clang 14's sanitizers map must not meet the kernel's random layout.
fixed=
setarch -R true 2>/dev/null && fixed="setarch -R"
found=0
# shellcheck disable=SC2086
GLOG_logtostderr=0 GLOG_minloglevel=3 \
  $fixed "$build/fuzz/$fuzzer" -seed="${CORBSLAM_FUZZ_SEED:-0}" -max_total_time="$seconds" $runs -max_len=16384 -timeout=20 \
  -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="$findings/" \
  "$corpus" "$here/corpus/$fuzzer" "$seeds" >"$findings/log" 2>&1 || found=1

units=$(sed -n 's/^stat::number_of_executed_units: *//p' "$findings/log")
covered=$(sed -n 's/.* cov: \([0-9]*\).*/\1/p' "$findings/log" | tail -n 1)
echo "$fuzzer: $seconds s, ${units:-?} executions, coverage ${covered:-?}"
[ $found -eq 1 ] || exit 0
echo "$fuzzer FOUND something: $findings"
grep -E "SUMMARY|ERROR|^ +#[0-9]+ |Test unit written|Base64" "$findings/log" || tail -n 20 "$findings/log"
exit 1
