#!/bin/sh
# live_page_test.sh BUILD: walks through the viewer's page in Chromium, before a real store, worker and
# robots with recorded data (services/viewer/page/dev/live.ts). Pictures are kept in
# BUILD/live_page. Ends with 77, "skipped", without Chromium or node, which is a failure under continuous
# integration, and where the page was not built: that needs npm's registry.
set -eu

build=$(cd "$1" && pwd)
root=$(cd "$(dirname "$0")/../.." && pwd)
skip() {
  echo "skipped: $1" >&2
  [ -z "${CI:-}" ] || exit 1
  exit 77
}
command -v node >/dev/null || skip "there is no node"
command -v "${CHROMIUM:-chromium}" >/dev/null || skip "there is no Chromium (deploy/packages_checks.txt)"
CHROMIUM=$(command -v "${CHROMIUM:-chromium}")
export CHROMIUM
if [ ! -e "$build/viewer_page/index.html" ]; then
  echo "skipped: the page was not built; what the build says of viewer_page says why" >&2
  exit 77
fi
cd "$build/viewer_page_work"
exec node build/run.mjs dev/live.ts --programs "$build/bin" --pictures "$build/live_page" \
  --source "tum:$root/tests/data/tum_fr1_xyz"
