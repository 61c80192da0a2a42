#!/bin/sh
# weekly.sh [STEP...]: the checks that are too long for each change, all of them or those named, one after
# the other. It prints a row for docs/testing.md's table "Once a week" as each ends, keeps what they print
# in out/weekly, and ends with 1 if one of them failed.
#
#   arm64    the kernels' unit tests, cross-compiled and run by qemu
#   fuzz     each fuzzer for CORBSLAM_FUZZ_SECONDS (20), with sanitizers
#   threads  clang's thread safety analysis of every source
#   tidy     clang-tidy on every source
#   address  all tests under AddressSanitizer and UndefinedBehaviourSanitizer
#   race     all tests without real programs under ThreadSanitizer
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
out=$root/out/weekly
mkdir -p "$out"
commit=$(git -C "$root" rev-parse --short=7 HEAD 2>/dev/null || echo unknown)

run() { # STEP
  case $1 in
    arm64 | threads | tidy) "$root/tests/check.sh" --all --only "$1" ;;
    fuzz) CORBSLAM_FUZZ_SEED=1 "$root/tests/fuzz/run.sh" "${CORBSLAM_FUZZ_SECONDS:-20}" ;;
    address) "$root/tests/sanitize.sh" address ;;
    race) "$root/tests/sanitize.sh" thread ;;
  esac
}

steps="arm64 fuzz threads tidy address race"
# shellcheck disable=SC2086
[ $# -gt 0 ] || set -- $steps
for step in "$@"; do
  case " $steps " in
    *" $step "*) ;;
    *)
      echo "weekly.sh: no step is called \"$step\"; there are: $steps" >&2
      exit 2
      ;;
  esac
done
"$root/deploy/install_packages.sh" packages_checks.txt
failed=0
for step in "$@"; do
  began=$(date +%s)
  ended=0
  run "$step" >"$out/$step.log" 2>&1 || ended=$?
  word=passed
  # 77: without git nothing says which sources there are.
  if [ "$ended" -eq 77 ]; then
    word=skipped
  elif [ "$ended" -ne 0 ]; then
    word="failed ($ended)"
    failed=1
    tail -n 20 "$out/$step.log" >&2
  fi
  echo "| \`$step\` | $(date +%F) | $commit | $word | $(($(date +%s) - began)) |"
done
exit $failed
