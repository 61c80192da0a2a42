#!/bin/sh
# collect.sh [--sysroot DIR] ROOT PROGRAM...: makes the folder ROOT the file system of an image that runs
# PROGRAM:
#
# /usr/bin          the programs, and health, which lies beside the first of them here
# /usr/lib          the shared libraries that these load, a robot's with GStreamer's plugins for cameras,
#                   and nothing else of Debian
# /usr/share/doc    the licences of the packages that the libraries are from, and the SBOM
# /var/lib/dpkg     what dpkg knows of these packages, so that scanners find them
#
# Runs where the programs were built: on Debian 12 with the libraries installed. Needs no root. With
# --sysroot, programs for arm64, and what deploy/arm64/make_sysroot.sh put into DIR; then qemu runs the
# loader, and ldconfig, which needs root.
set -eu

sysroot=
if [ "${1:-}" = --sysroot ] && [ $# -ge 2 ]; then
  sysroot=$(cd "$2" && pwd)
  shift 2
fi
[ $# -ge 2 ] || { sed -n '2,14s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
root=$(cd "$1" && pwd)
shift
# Of the user that the images run as.
uid=10001

fail() {
  echo "collect.sh: $*" >&2
  exit 1
}

[ ! -e "$root" ] || [ -z "$(ls -A "$root")" ] || fail "$root is not empty"
umask 022
for folder in etc usr/bin usr/lib usr/lib64 usr/share/corbslam usr/share/doc/corbslam \
  var/lib/dpkg/status.d tmp; do
  mkdir -p "$root/$folder"
done
chmod 1777 "$root/tmp"
for folder in bin lib lib64; do ln -s "usr/$folder" "$root/$folder"; done
lists=$(mktemp -d)
trap 'rm -rf "$lists"' EXIT

# Of a sysroot, too, the files are named as programs see them.
emulator="qemu-aarch64-static -L $sysroot"
if [ -n "$sysroot" ]; then
  command -v qemu-aarch64-static >/dev/null || fail "no qemu-aarch64-static (Debian package qemu-user-static)"
  export DPKG_ADMINDIR="$sysroot/var/lib/dpkg"
fi
list_libraries() { # PROGRAM
  if [ -n "$sysroot" ]; then
    $emulator "$sysroot/lib/ld-linux-aarch64.so.1" --list "$1" > "$lists/listed" || return 1
    sed "s|$sysroot||" "$lists/listed"
  else
    ldd "$1"
  fi
}
# Prints where links end, of the names on its input.
resolve() {
  if [ -n "$sysroot" ]; then
    sed "s|^|$sysroot|" | xargs readlink -f | sed "s|^$sysroot||"
  else
    xargs readlink -f
  fi
}
# Copies the files that its input names, links as what they lead to.
copy_files() {
  (cd "$sysroot/" && sed 's|^/||' | xargs cp -L --parents -t "$root")
}
# add_libraries FILE: notes what the program or library FILE loads.
add_libraries() {
  list_libraries "$1" > "$lists/ldd" || fail "$1 is not dynamically linked"
  if grep "not found" "$lists/ldd" >&2; then fail "$1 lacks the libraries above"; fi
  # "NAME => FILE (ADDRESS)", and the loader's "FILE (ADDRESS)".
  awk '$2 == "=>" && $3 ~ /^\// {print $3} $1 ~ /^\// {print $1}' "$lists/ldd" |
    sed "s|^$sysroot||" >> "$lists/files"
}

for program in "$@" "${1%/*}/health"; do
  [ -x "$program" ] || fail "$program is no program"
  install -m 755 "$program" "$root/usr/bin/${program##*/}"
  add_libraries "$program"
done
# GStreamer opens its plugins by name, which ldd does not see: those for cameras (docs/live.md), no more.
if gstreamer=$(grep -m 1 /libgstreamer-1.0 "$lists/files"); then
  gstreamer=${gstreamer%/*}
  echo "$gstreamer/gstreamer1.0/gstreamer-1.0/gst-plugin-scanner" > "$lists/plugins"
  for plugin in app coreelements jpeg multifile playback png rawparse rtp rtpmanager rtsp tcp \
    typefindfunctions udp video4linux2 videobox videoconvertscale videocrop videofilter videorate \
    videotestsrc; do
    echo "$gstreamer/gstreamer-1.0/libgst$plugin.so" >> "$lists/plugins"
  done
  while read -r file; do
    [ -e "$sysroot$file" ] || fail "$file is missing: install what deploy/packages.txt names"
    echo "$file" >> "$lists/files"
    add_libraries "$sysroot$file"
  done < "$lists/plugins"
fi
sort -u "$lists/files" > "$lists/libraries"
# Where the links of Debian's alternatives end, for dpkg to know them; it may do so without the /usr
# of a merged system.
resolve < "$lists/libraries" > "$lists/real"
sed 'p; s|^/usr||' "$lists/real" | xargs dpkg-query -S > "$lists/found" 2>/dev/null || true
sed 's/.*: //; s|^/usr||' "$lists/found" | sort -u > "$lists/known"
sed 's|^/usr||' "$lists/real" | sort -u | comm -23 - "$lists/known" > "$lists/unknown"
[ ! -s "$lists/unknown" ] || fail "$(tr '\n' ' ' < "$lists/unknown")is of no Debian package"
copy_files < "$lists/libraries"
sed 's/: .*//' "$lists/found" > "$lists/owners"
# Two packages may be named at once, "a, b: file", and with their architecture.
tr ',' '\n' < "$lists/owners" | sed 's/ //g; s/:.*//' | sort -u > "$lists/packages"

# One paragraph a package.
xargs dpkg-query -s < "$lists/packages" |
  awk -v folder="$root/var/lib/dpkg/status.d/" '
    /^Package: / { file = folder $2 }
    NF { print > file }
    !NF { close(file) }'
sed 's|.*|/usr/share/doc/&/copyright|' "$lists/packages" | copy_files ||
  fail "a licence is missing: its package can't be shipped"

install -m 644 "$here/../../slam/vocabulary/data/corbslam.voc" "$root/usr/share/corbslam/"
# The page lies beside the programs' folder, where it was built.
page=${1%/*}/../viewer_page
if [ "${1##*/}" = map_viewer ]; then
  [ -e "$page/index.html" ] || fail "$page: the viewer's page was not built (deploy/packages_page.txt)"
  cp -R "$page" "$root/usr/share/corbslam/viewer"
fi
install -m 644 "$here/../../LICENSE" "$root/usr/share/doc/corbslam/copyright"
install -m 644 /etc/os-release "$root/etc/os-release"
echo "root:x:0:0:root:/:/usr/bin/false
corbslam:x:$uid:$uid::/var/lib/corbslam:/usr/bin/false" > "$root/etc/passwd"
echo "root:x:0:
corbslam:x:$uid:" > "$root/etc/group"
echo "hosts: files dns" > "$root/etc/nsswitch.conf"
sed '/gstreamer-1.0\//d; s/[^/]*$//' "$lists/libraries" | sort -u > "$root/etc/ld.so.conf"
if [ -n "$sysroot" ]; then
  $emulator "$sysroot/sbin/ldconfig" -r "$root" -X
else
  /sbin/ldconfig -r "$root" -X
fi

"$here/sbom.sh" "$lists/packages" "$@" "${1%/*}/health" > "$root/usr/share/doc/corbslam/sbom.spdx.json"
