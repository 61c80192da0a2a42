#!/bin/sh
# make_sysroot.sh [--kernels] FOLDER: puts the headers and libraries of Debian 12's arm64 packages that
# programs are compiled and linked with (the libraries of ../packages.txt and packages_libraries.txt; with
# --kernels the few of packages_kernels*.txt) into FOLDER. Nothing of this machine changes, and root is
# not needed. What is there already for the same list stays. DEBIAN_MIRROR names a mirror
# (http://deb.debian.org/debian); CORBSLAM_ARM64_PACKAGES a folder that keeps the packages, so that the
# next time fetches what is new.
#
# Two architectures' -dev packages can't all lie beside each other in one system: some hold the same
# files, and apt wants to remove one for the other. In a folder of its own nothing is in their way.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
kernels=
if [ "${1:-}" = --kernels ]; then
  kernels=yes
  shift
fi
[ $# -eq 1 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
mkdir -p "$1"
root=$(cd "$1" && pwd)
apt=$root/.apt
archives=${CORBSLAM_ARM64_PACKAGES:-$apt/archives}
case $archives in /*) ;; *) archives=$PWD/$archives ;; esac

wanted() {
  if [ -n "$kernels" ]; then
    sed 's/#.*//' "$here/packages_kernels.txt"
  else
    sed 's/#.*//' "$here/../packages.txt" | grep -E '^(lib.*|nlohmann-json3|prometheus-cpp|zlib1g)-dev$'
    sed 's/#.*//' "$here/packages_libraries.txt"
  fi
  sed 's/#.*//' "$here/packages_target.txt"
}

# OpenCV's headers depend on those of all of OpenCV, and these on GDAL, Mesa and Qt.
alone() {
  [ -z "$kernels" ] || sed 's/#.*//' "$here/packages_kernels_alone.txt"
}

# apt's own folders lie below the new root: it knows of nothing that is installed here.
configure_apt() {
  keyring=/usr/share/keyrings/debian-archive-keyring.gpg
  [ -e "$keyring" ] || {
    echo "make_sysroot.sh: no $keyring (Debian package debian-archive-keyring)" >&2
    exit 2
  }
  mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
  signed="[arch=arm64 signed-by=$keyring]"
  mkdir -p "$apt/lists/partial" "$apt/none/partial" "$apt/etc/apt.conf.d" "$apt/etc/preferences.d" \
    "$archives/partial"
  : >"$apt/status"
  cat >"$apt/etc/sources.list" <<SOURCES
deb $signed $mirror bookworm main
deb $signed $mirror bookworm-updates main
deb $signed ${DEBIAN_SECURITY_MIRROR:-$mirror-security} bookworm-security main
SOURCES
  cat >"$apt/apt.conf" <<CONF
APT::Architecture "arm64";
APT::Architectures "arm64";
APT::Install-Recommends "false";
APT::Sandbox::User "";
Acquire::Languages "none";
Acquire::Retries "3";
Dir::Etc "$apt/etc";
Dir::Etc::SourceParts "/dev/null";
Dir::State "$apt";
Dir::State::status "$apt/status";
Dir::Cache "$apt";
Dir::Cache::archives "$(cd "$archives" && pwd)";
CONF
  export APT_CONFIG="$apt/apt.conf"
}

# Fetches packages; $apt/files has the names of their files.
fetch() { # PACKAGE...
  apt-get update -q >"$apt/log" 2>&1 || return 1
  # Where none is there yet, apt tells of all.
  apt-get install -q -y --print-uris -o Dir::Cache::archives="$apt/none" "$@" >"$apt/uris" || return 1
  awk '/^.http/ { print $2 }' "$apt/uris" >"$apt/files"
  apt-get install -q -y --download-only "$@" >>"$apt/log" 2>&1 || return 1
  for name in $(alone); do
    (cd "$archives" && apt-get download -q "$name" >>"$apt/log" 2>&1) || return 1
    (cd "$archives" && ls -t "${name}"_*.deb | head -n 1) >>"$apt/files"
  done
}

# Unpacks a package, of its papers the licence, and notes what dpkg would, for dpkg-query and dpkg-shlibdeps.
unpack() { # FILE
  dpkg-deb --control "$1" "$apt/control"
  name=$(sed -n 's/^Package: //p' "$apt/control/control")
  # Of these several architectures may be installed at once.
  ! grep -qx 'Multi-Arch: same' "$apt/control/control" || name=$name:arm64
  info=$root/var/lib/dpkg/info/$name
  dpkg-deb --fsys-tarfile "$1" |
    tar -xv -C "$root" --keep-directory-symlink --no-same-owner --exclude='./usr/share/doc/*/[!c]*' \
      --exclude='./usr/share/doc/*/c[!o]*' --exclude='./usr/share/man' --exclude='./usr/share/locale' \
      --exclude='./dev' | sed -n 's|^\./\(.*[^/]\)$|/\1|p' >"$info.list"
  for file in symbols shlibs; do
    [ ! -e "$apt/control/$file" ] || mv "$apt/control/$file" "$info.$file"
  done
  { sed 's/^Package: .*/&\nStatus: install ok installed/' "$apt/control/control"; echo; } \
    >>"$root/var/lib/dpkg/status"
  rm -rf "$apt/control"
}

# Does what maintainers' scripts would have done, the alternatives of BLAS, and turns links that begin at
# /, which would lead to this machine's files.
set_links() {
  library=$root/usr/lib/aarch64-linux-gnu
  for name in blas lapack; do
    for suffix in so so.3 a; do
      [ ! -e "$library/$name/lib$name.$suffix" ] ||
        ln -sf "$name/lib$name.$suffix" "$library/lib$name.$suffix"
    done
  done
  find "$root" -path "$apt" -prune -o -type l -lname '/*' -print | while read -r link; do
    ln -sfr "$root$(readlink "$link")" "$link"
  done
}

# Lists of libraries in CMake's files, as Ceres' and RocksDB's, name some by the path on an arm64 machine.
set_paths() {
  find "$root/usr/lib" -name '*.cmake' -exec \
    sed -i "s|;/usr/lib/aarch64-linux-gnu/lib|;$root/usr/lib/aarch64-linux-gnu/lib|g" {} +
}

packages=$(wanted | sort | xargs)
made="$packages; $(alone | xargs); by $(cksum <"$0")"
[ "$(cat "$root/.made" 2>/dev/null || true)" != "$made" ] || exit 0
find "$root" -mindepth 1 -maxdepth 1 -exec rm -rf {} +
configure_apt
# shellcheck disable=SC2086
fetch $packages || {
  tail -n 20 "$apt/log" >&2
  exit 1
}
# /lib is usr/lib, as on every Debian 12.
mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates"
echo 1 >"$root/var/lib/dpkg/info/format"
echo arm64 >"$root/var/lib/dpkg/arch"
for folder in bin lib sbin; do
  mkdir -p "$root/usr/$folder"
  ln -s "usr/$folder" "$root/$folder"
done
while read -r file; do
  unpack "$archives/$file"
done <"$apt/files"
set_links
set_paths
rm -rf "$apt/archives" "$apt/lists" "$apt"/*cache.bin
echo "$made" >"$root/.made"
