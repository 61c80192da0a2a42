#!/bin/sh
# build.sh [--tests] [--packages FOLDER]: builds the programs for arm64 on amd64 (Debian 12) into build/arm64, and
# their Debian packages into the folder, or into out/packages_arm64. With --tests also the unit tests of slam/
# and client_agent/, which qemu then runs. What is missing is installed (as root or by sudo) and fetched
# (make_sysroot.sh). JOBS says how many files are compiled at a time (as many as there are processors).
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
jobs=${JOBS:-$(nproc)}
tests=OFF
out=$root/out/packages_arm64
while [ $# -gt 0 ]; do
  case $1 in
    --tests) tests=ON ;;
    --packages)
      [ $# -ge 2 ] || { echo "build.sh: --packages needs a folder" >&2; exit 2; }
      out=$2
      shift
      ;;
    *) sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
  shift
done
mkdir -p "$out"
out=$(cd "$out" && pwd)

"$root/deploy/install_packages.sh" arm64/packages.txt
export CORBSLAM_ARM64_SYSROOT="${CORBSLAM_ARM64_SYSROOT:-$root/build/arm64_sysroot}"
"$here/make_sysroot.sh" "$CORBSLAM_ARM64_SYSROOT"
cd "$root"
cmake --preset arm64 "-DCORBSLAM_BUILD_TESTS=$tests" -DCORBSLAM_BUILD_BENCHMARKS=OFF

# Targets that the folders' own CMakeLists.txt name as tests.
if [ "$tests" = ON ]; then
  names=$(find slam client_agent -name CMakeLists.txt -exec \
    sed -n 's/^ *corbslam_test(\([a-z0-9_]*\).*/\1/p' {} + | sort)
  # shellcheck disable=SC2086
  cmake --build --preset arm64 -j "$jobs" --target $names
  ctest --test-dir build/arm64 --output-on-failure -j "$jobs" -R "^($(echo "$names" | xargs | tr ' ' '|'))\\."
fi

cmake --build --preset arm64 -j "$jobs" --target installed health
rm -f "$out"/corbslam-*.deb
# cpack leaves what it packed beside the packages.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$work" && cpack -G DEB -D "SHLIBDEPS_EXECUTABLE=$here/shlibdeps.sh" \
  --config "$root/build/arm64/CPackConfig.cmake")
mv "$work"/corbslam-*.deb "$out"
ls -l "$out"
