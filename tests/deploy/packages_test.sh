#!/bin/bash
# packages_test.sh BUILD: makes the Debian packages of the build folder and looks into them: what is
# where, that no file is in two, that they name what their programs load, that the papers are there,
# and that the programs run, and find their vocabulary, wherever they are unpacked.
set -euo pipefail

command -v dpkg-shlibdeps >/dev/null || { echo "skipped: there is no dpkg-dev" >&2; exit 77; }
build=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "$*" >&2
  exit 1
}

# has PACKAGE PATH...: the package holds these files.
has() {
  local package=$1 path
  shift
  for path in "$@"; do
    grep -qx "\./$path" "$work/$package.files" || fail "$package has no $path"
  done
}

# says TEXT COMMAND...: the command succeeds, and prints the text.
says() {
  local text=$1 said
  shift
  said=$("$@" 2>&1) || fail "$* ended with $?: $said"
  [[ $said == *"$text"* ]] || fail "$* does not say \"$text\" but: $said"
}

(cd "$work" && cpack -G DEB --config "$build/CPackConfig.cmake" > cpack.log 2>&1) ||
  { cat "$work/cpack.log" >&2; exit 1; }
packages="common server robot push dev"
# Where DDS was there when it was built.
if [ -x "$build/bin/corbslam_ros2" ]; then packages="$packages ros2"; fi
for package in $packages; do
  deb=$(echo "$work"/corbslam-"$package"_*.deb)
  [ -f "$deb" ] || fail "there is no package corbslam-$package"
  dpkg-deb -c "$deb" | awk '$1 !~ /^d/ {print $6}' | sort > "$work/$package.files"
  dpkg-deb -f "$deb" > "$work/$package.control"
  dpkg-deb -x "$deb" "$work/root"
  [ $package = dev ] || grep -q "^Depends:.*libc6" "$work/$package.control" || fail "$package names no libraries"
  has $package "usr/share/doc/corbslam-$package/copyright" "usr/share/doc/corbslam-$package/changelog.gz"
done

twice=$(sort "$work"/*.files | uniq -d)
[ -z "$twice" ] || fail "in two packages: $twice"
has common usr/bin/corbslam usr/bin/simulated_agent usr/share/corbslam/corbslam.voc usr/share/doc/corbslam/operations.md \
  usr/share/doc/corbslam/results/accuracy.md
! grep "/doc/corbslam/lab/" "$work"/*.files || fail "the lab's diary is in a package"
has server usr/bin/map_store usr/bin/fusion_worker usr/lib/systemd/system/map_store.service \
  usr/bin/map_viewer usr/lib/systemd/system/map_viewer.service etc/corbslam/map_viewer.env \
  usr/lib/systemd/system/fusion_worker.service etc/corbslam/map_store.env etc/corbslam/fusion_worker.env \
  usr/lib/systemd/system/corbslam_backup.service usr/lib/systemd/system/corbslam_backup.timer etc/corbslam/corbslam_backup.env \
  etc/corbslam/revoked_tokens
has robot usr/bin/client_agent usr/lib/systemd/system/client_agent@.service
[[ $packages != *ros2 ]] || has ros2 usr/bin/corbslam_ros2 usr/share/man/man1/corbslam_ros2.1.gz \
  usr/share/doc/corbslam-ros2/examples/corbslam.launch.py
has push usr/lib/libcorbslam_push.so.0
has dev usr/include/corbslam/push.h usr/include/corbslam/push.hpp usr/include/corbslam/v1/agent_service.grpc.pb.h \
  usr/lib/libcorbslam_api.a usr/lib/cmake/corbslam/corbslamConfig.cmake usr/lib/cmake/corbslam/corbslam-push.cmake \
  usr/share/corbslam/proto/corbslam/v1/agent_service.proto usr/share/doc/corbslam-dev/examples/push_folder.py
grep -q "^Depends: corbslam-push (=" "$work/dev.control" || fail "dev does not depend on push"
grep -q "corbslam-common (=" "$work/server.control" || fail "server does not depend on common"
grep -q "corbslam-common (=" "$work/robot.control" || fail "robot does not depend on common"
says /etc/corbslam/map_store.env dpkg-deb -I "$work"/corbslam-server_*.deb conffiles

for program in corbslam map_store fusion_worker map_viewer client_agent simulated_agent; do
  says 0.1.0 "$work/root/usr/bin/$program" --version
  says "$program" "$work/root/usr/bin/$program" --help
  zcat "$work/root/usr/share/man/man1/$program.1.gz" > "$work/page.1"
  if command -v man >/dev/null; then
    warnings=$(LC_ALL=C.UTF-8 man --warnings -l "$work/page.1" 2>&1 >/dev/null)
    [ -z "$warnings" ] || fail "the manual of $program: $warnings"
  fi
  (
    # shellcheck disable=SC1090
    source "$work/root/usr/share/bash-completion/completions/$program"
    COMP_WORDS=("$work/root/usr/bin/$program" --vers) COMP_CWORD=1
    _corbslam_complete
    [ "${COMPREPLY[*]}" = --version ]
  ) || fail "the completion of $program does not know --version"
  grep -q "^#compdef .*$program" "$work/root/usr/share/zsh/vendor-completions/_$program" ||
    fail "zsh has no completion of $program"
done
says "$work/root/usr/share/corbslam/corbslam.voc" "$work/root/usr/bin/map_store" --help
says "the configuration is valid" "$work/root/usr/bin/map_store" --validate-config --insecure
says "$work/root/usr/share/corbslam/corbslam.voc" "$work/root/usr/bin/corbslam" doctor --insecure

# The same without packages, in any folder.
cmake --install "$build" --prefix "$work/anywhere" > "$work/install.log" 2>&1 ||
  { cat "$work/install.log" >&2; exit 1; }
says "$work/anywhere/share/corbslam/corbslam.voc" "$work/anywhere/bin/map_store" --help
[ -f "$work/anywhere/etc/corbslam/map_store.env" ] || fail "cmake --install has no map_store.env"
wc -c "$work"/*.deb | awk -v work="$work/" '{sub(work, ""); print}'
