#!/bin/sh
# install_packages.sh [LIST...]: installs those of packages.txt, and of further lists in this folder,
# that are missing; needs root (or sudo) only then.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
missing=
for package in $(cd "$here" && sed 's/#.*//' packages.txt "$@"); do
  state=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
  [ "$state" = "install ok installed" ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

echo "installing:$missing"
as_root=
[ "$(id -u)" -eq 0 ] || as_root=sudo
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get update -q
# shellcheck disable=SC2086
$as_root apt-get install -q -y --no-install-recommends $missing
