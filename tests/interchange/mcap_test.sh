#!/bin/sh
# mcap_test.sh WRITER FOLDER: has WRITER write recordings into FOLDER, and reads them with the packages
# that other programs read them with, which npm fetches into FOLDER as package-lock.json pins them.
# 77: they can't be had here; with CI set that is a failure where node is there.
set -eu

writer=$1
work=$2
here=$(cd "$(dirname "$0")" && pwd)

if ! command -v node >/dev/null; then
  echo "skipped: no node"
  exit 77
fi
mkdir -p "$work"
cp "$here/package.json" "$here/package-lock.json" "$here"/*.mjs "$work"
if ! cmp -s "$work/package-lock.json" "$work/node_modules/.fetched"; then
  if ! (cd "$work" && npm ci --ignore-scripts --no-audit --no-fund); then
    echo "npm can't fetch the packages"
    [ -n "${CI:-}" ] || exit 77
    exit 1
  fi
  cp "$work/package-lock.json" "$work/node_modules/.fetched"
fi
"$writer" "$work"
cd "$work"
exec node mcap_check.mjs small.mcap empty.mcap large.mcap
