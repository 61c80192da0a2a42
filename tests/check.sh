#!/bin/sh
# check.sh --all|--changed [BASE] [--only STEP,...]: what machines find in the C++ sources without
# running a mission. docs/testing.md has the steps, and how long each takes.
#
#   format   clang-format changes nothing
#   threads  clang reads each source, which the build does not do without precompiled headers: no
#            include is missing; and its thread safety analysis
#   tidy     clang-tidy with .clang-tidy
#   address  unit tests of the map store and of the services under AddressSanitizer
#   arm64    unit tests of the folders that have code for an instruction set, cross-compiled and run by
#            qemu (deploy/arm64)
#
# --all does all of it. --changed does the first three on what differs from BASE (a commit; else
# origin/main where that is another one, else HEAD~1): sources, and those that include a header that
# differs; of these the first 40, since a header of all makes it an hour's work (that is --all's).
# Exit status 1: there are findings; 2: wrong usage, or a tool is missing; 77: there is no
# commit to compare with.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
build=build/release
out=build/checks
most=40 # Sources that --changed reads.

usage() {
  echo "usage: tests/check.sh --all|--changed [BASE] [--only format,threads,tidy,address,arm64]" >&2
  exit 2
}

scope=
base=
only=
while [ $# -gt 0 ]; do
  case $1 in
    --all) scope=all ;;
    --changed)
      scope=changed
      case ${2:-} in
        "" | --*) ;;
        *)
          base=$2
          shift
          ;;
      esac
      ;;
    --only)
      [ $# -ge 2 ] || usage
      only="$only $(echo "$2" | tr ',' ' ')"
      shift
      ;;
    *) usage ;;
  esac
  shift
done
[ -n "$scope" ] || usage
if [ -z "$only" ]; then
  only="format threads tidy"
  [ "$scope" = changed ] || only="$only address arm64"
fi
for step in $only; do
  case $step in
    format | threads | tidy | address | arm64) ;;
    *) usage ;;
  esac
done

missing=
need() { # TOOL PACKAGE
  command -v "$1" >/dev/null || missing="$missing
  $1 (Debian package $2)"
}
for step in $only; do
  case $step in
    format) need clang-format-14 clang-format-14 ;;
    threads) need clang++-14 clang-14 ;;
    tidy)
      need clang++-14 clang-14
      need clang-tidy-14 clang-tidy-14
      ;;
    arm64)
      need aarch64-linux-gnu-g++ g++-aarch64-linux-gnu
      need qemu-aarch64-static qemu-user-static
      ;;
  esac
done
if [ -n "$missing" ]; then
  echo "check.sh: not installed (deploy/install_packages.sh packages_checks.txt installs all):$missing" >&2
  exit 2
fi

# A release's archive has no history.
git rev-parse --is-inside-work-tree >/dev/null 2>&1 || {
  echo "check.sh: this is no git repository: what to check is not known" >&2
  exit 77
}
mkdir -p "$out"
all_sources() { git ls-files --cached --others --exclude-standard -- '*.cc' '*.h'; }

find_base() {
  [ -z "$base" ] || return 0
  head=$(git rev-parse HEAD)
  main=$(git merge-base HEAD origin/main 2>/dev/null || true)
  if [ -n "$main" ] && [ "$main" != "$head" ]; then
    base=$main
  else
    base=$(git rev-parse --verify --quiet HEAD~1 || true)
  fi
  [ -n "$base" ] || {
    echo "check.sh: neither origin/main nor HEAD~1 is there to compare with; name a commit" >&2
    exit 77
  }
}

# In $out/files.
list_sources() {
  if [ "$scope" = all ]; then
    all_sources >"$out/files"
    return
  fi
  find_base
  git rev-parse --verify --quiet "$base^{commit}" >/dev/null || {
    echo "check.sh: there is no commit $base" >&2
    exit 2
  }
  {
    git diff --name-only --diff-filter=d "$base" -- '*.cc' '*.h'
    git ls-files --others --exclude-standard -- '*.cc' '*.h'
  } | sort -u >"$out/files"
  echo "compared with $base: $(wc -l <"$out/files") sources and headers differ"
}

# Those of $out/files, and what includes a header among them, in $out/reached.
list_reached() {
  cp "$out/files" "$out/reached"
  [ "$scope" = changed ] || return 0
  sed -n 's/.*\.h$/#include "&"/p' "$out/files" >"$out/includes"
  [ ! -s "$out/includes" ] ||
    all_sources | grep '\.cc$' | xargs grep -lFf "$out/includes" >>"$out/reached" || true
  grep '\.cc$' "$out/reached" | awk '!seen[$0]++' >"$out/all_reached" || true
  head -n "$most" "$out/all_reached" >"$out/reached"
  left=$(($(wc -l <"$out/all_reached") - $(wc -l <"$out/reached")))
  [ "$left" -eq 0 ] || echo "$left more sources are reached, and not looked at: --all does"
}

# The compile database, with every header that is generated.
prepare_build() {
  [ -f "$build/build.ninja" ] || cmake --preset release -DCORBSLAM_BUILD_TESTS=ON \
    -DCORBSLAM_BUILD_BENCHMARKS=ON >/dev/null
  ninja -C "$build" -t targets rule CUSTOM_COMMAND | grep '\.pb\.h$' |
    xargs ninja -C "$build" >"$out/generated.log" || {
    cat "$out/generated.log"
    return 1
  }
}

check_format() {
  count=$(wc -l <"$out/files")
  [ "$count" -gt 0 ] || return 0
  xargs -P "$(nproc)" -n 20 clang-format-14 --dry-run --Werror <"$out/files" \
    >"$out/format.txt" 2>&1
}

check_by_ninja() { # STEP
  prepare_build || return 1
  list_reached
  count=$(tests/check/make_ninja.py "$1" "$build/compile_commands.json" "$out/$1.ninja" \
    "$out/reached") || return 1
  ok=0
  ninja -f "$out/$1.ninja" -k 0 >"$out/$1.log" 2>&1 || ok=1
  # What passed has nothing to say, and what a header has is found in every source.
  grep -vE '^(\[[0-9]+/[0-9]+\]|ninja: |FAILED: |clang\+\+-14 |[0-9]+ (warnings?|errors?) )' \
    "$out/$1.log" | grep -vE '^(Suppressed|Use -header-filter|Error while) ?' |
    awk '!seen[$0]++' >"$out/$1.txt" || true
  # A tool that broke may have said nothing of a source.
  [ $ok -eq 0 ] || [ -s "$out/$1.txt" ] || tail -n 50 "$out/$1.log" >"$out/$1.txt"
  return $ok
}

# Targets that the folders' own CMakeLists.txt name as tests.
unit_tests() {
  find map_store services -path services/simulation -prune -o -name CMakeLists.txt \
    -exec sed -n 's/^ *corbslam_test(\([a-z0-9_]*\).*/\1/p' {} +
}

check_address() {
  tests=$(unit_tests | sort | tr '\n' ' ')
  count=$(echo "$tests" | wc -w)
  pattern="^($(echo "$tests" | sed 's/ $//; s/ /|/g'))\\."
  CORBSLAM_SANITIZE_TARGETS=$tests tests/sanitize.sh address -R "$pattern" \
    >"$out/address.txt" 2>&1
}

check_arm64() {
  root_of_arm64=$root/build/arm64_kernels_sysroot
  deploy/arm64/make_sysroot.sh --kernels "$root_of_arm64" >"$out/arm64.txt" 2>&1 || return 1
  cmake --preset arm64 -B build/arm64_kernels -DCORBSLAM_ONLY_KERNELS=ON -DCORBSLAM_BUILD_TESTS=ON \
    -DCORBSLAM_BUILD_BENCHMARKS=OFF "-DCORBSLAM_ARM64_SYSROOT=$root_of_arm64" >>"$out/arm64.txt" 2>&1 || return 1
  cmake --build build/arm64_kernels --target kernels >>"$out/arm64.txt" 2>&1 || return 1
  ctest --test-dir build/arm64_kernels -j "$(nproc)" --output-on-failure --no-tests=error \
    -R '^(slam_util|features|slam_coding|services_simulation_renderer)_test\.' >>"$out/arm64.txt" 2>&1 || return 1
  count=$(sed -n 's/.* tests failed out of //p' "$out/arm64.txt")
}

run_step() { # STEP
  echo "== $1"
  count=0
  began=$(date +%s)
  verdict=passed
  : >"$out/$1.txt"
  case $1 in
    format) check_format || verdict=FAILED ;;
    threads | tidy) check_by_ninja "$1" || verdict=FAILED ;;
    address) check_address || verdict=FAILED ;;
    arm64) check_arm64 || verdict=FAILED ;;
  esac
  seconds=$(($(date +%s) - began))
  if [ "$verdict" = FAILED ]; then
    failed=1
    cat "$out/$1.txt"
  fi
  echo "$1: $verdict, $count looked at, $seconds s"
  echo "| $1 | $count | $seconds | $verdict |" >>"$out/table.txt"
}

failed=0
: >"$out/table.txt"
list_sources
for step in $only; do
  run_step "$step"
done
echo
echo "| step | looked at | s | |"
echo "| --- | --- | --- | --- |"
cat "$out/table.txt"
exit $failed
