#!/bin/sh
# systemd_test.sh PROGRAMS: systemd understands our units as they are installed with the programs in
# the folder PROGRAMS, and they are as closed as they were: their exposure, by systemd's own measure
# from 0 to 10, is at most 1.5, and 1.6 of robots, which open cameras. Ends with 77, "skipped", without systemd's tools.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
if ! command -v systemd-analyze >/dev/null; then
  echo "skipped: there is no systemd-analyze (deploy/packages_checks.txt)" >&2
  [ -z "${CI:-}" ] || exit 1
  exit 77
fi
programs=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for unit in "$root"/deploy/systemd/*.service; do
  # verify looks for the program, security for nothing.
  installed=$work/$(basename "$unit" | sed 's/@/@alpha/')
  sed "s|/usr/bin/|$programs/|" "$unit" > "$installed"
  systemd-analyze verify --man=no "$installed" > "$work/said" 2>&1 ||
    { cat "$work/said" >&2; exit 1; }
  # Lines about units of this machine are not ours to judge.
  if grep -F "${installed##*/}" "$work/said" >&2; then exit 1; fi
  case $installed in
    *client_agent@*) most=16 ;;
    *) most=15 ;;
  esac
  systemd-analyze security --offline=true --threshold=$most "$installed" > "$work/said" 2>&1 ||
    { cat "$work/said" >&2; exit 1; }
  tail -n 1 "$work/said"
done
