#!/bin/sh
# install_test.sh BUILD CMAKE: installs each component of a build into a folder, and looks at what came.
set -eu

build=$1
cmake=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for component in common robot server; do
  "$cmake" --install "$build" --prefix "$work" --component "$component" >"$work/log" ||
    { tail -n 20 "$work/log" >&2; exit 1; }
done
fail() {
  echo "$1" >&2
  exit 1
}
[ -x "$work/bin/map_store" ] || fail "bin/map_store is missing"
[ -e "$work/share/corbslam/corbslam.voc" ] || fail "share/corbslam/corbslam.voc is missing"
page=$work/share/corbslam/viewer
if [ -e "$build/viewer_page/index.html" ]; then
  diff -rq "$build/viewer_page" "$page" >&2 || fail "share/corbslam/viewer is not the page that was built"
else
  [ ! -d "$page" ] || [ -z "$(ls -A "$page")" ] || fail "share/corbslam/viewer has files, and no page was built"
fi
# Programs of three hundred megabytes at most, and documents.
kilobytes=$(du -sk "$work" | cut -f1)
[ "$kilobytes" -lt 600000 ] || fail "what is installed takes $kilobytes KiB"
