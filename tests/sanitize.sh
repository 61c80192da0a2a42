#!/bin/sh
# sanitize.sh address|thread [CTEST ARGUMENT...]: builds everything with AddressSanitizer and
# UndefinedBehaviourSanitizer, or with ThreadSanitizer, and runs the tests. What a sanitizer says is
# in BUILD/reports, one file a process; any report is a failure. docs/testing.md.
#
# CORBSLAM_SANITIZE_BUILD: another folder than build/asan or build/tsan. CORBSLAM_SANITIZE_TARGETS:
# builds no more than these.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
kind=${1:-}
case $kind in
  address) preset=asan ;;
  thread) preset=tsan ;;
  *)
    echo "usage: tests/sanitize.sh address|thread [CTEST ARGUMENT...]" >&2
    exit 2
    ;;
esac
shift
# Real programs take their time under ThreadSanitizer, and share no memory.
[ "$kind" = address ] || set -- -LE integration "$@"
build=${CORBSLAM_SANITIZE_BUILD:-$root/build/$preset}

"$root/deploy/install_packages.sh" packages_fuzz.txt
cd "$root"
cmake --preset "$preset" -B "$build" -DCORBSLAM_BUILD_BENCHMARKS=OFF
# shellcheck disable=SC2086
cmake --build "$build" ${CORBSLAM_SANITIZE_TARGETS:+--target $CORBSLAM_SANITIZE_TARGETS}

rm -rf "$build/reports"
mkdir -p "$build/reports"
# Quoted: the values end at spaces and colons otherwise.
common="log_path='$build/reports/report':handle_abort=1"
export ASAN_OPTIONS="$common:detect_stack_use_after_return=1:strict_string_checks=1"
export LSAN_OPTIONS="suppressions='$root/tests/sanitize/leaks.txt':print_suppressions=0"
export UBSAN_OPTIONS="$common:print_stacktrace=1"
export TSAN_OPTIONS="$common:suppressions='$root/tests/sanitize/threads.txt':second_deadlock_stack=1"
# The sanitizers of clang 14 can't have their shadow memory where some kernels' random layouts put
# other things.
fixed=
setarch -R true 2>/dev/null && fixed="setarch -R"
failed=0
$fixed ctest --test-dir "$build" --output-on-failure -j "$(nproc)" "$@" || failed=1
for report in "$build"/reports/*; do
  [ -e "$report" ] || continue
  failed=1
  echo "== $report"
  cat "$report"
done
exit $failed
