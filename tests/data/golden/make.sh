#!/bin/sh
# make.sh PROGRAMS: makes a backup and a journal's folder with the programs in PROGRAMS; see README.md.
set -eu

programs=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
store=
trap '[ -z "$store" ] || kill "$store"; rm -rf "$work"' EXIT

"$programs/map_store" --listen 127.0.0.1:0 --data-dir "$work/data" --insecure \
  > "$work/store.log" 2>&1 &
store=$!
address=
for _ in $(seq 100); do
  address=$(sed -n 's/^listening on //p' "$work/store.log")
  [ -z "$address" ] || break
  sleep 0.1
done
"$programs/simulated_agent" --source "sim:city?seed=7&frames=0:9" --features 1000 --insecure \
  --server "$address" --mission golden --agent alpha > "$work/agent.log" 2>&1 ||
  { cat "$work/agent.log" >&2; exit 1; }
"$programs/corbslam" mission list --insecure --server "$address"
"$programs/corbslam" mission backup --insecure --server "$address" --mission golden \
  --out "$work/backup"
kill "$store"
wait "$store" || true
store=
# A backup has its format in bytes 8 to 11; a folder's is what `journal check` would refuse.
format=$(od -An -tu4 -j8 -N4 "$work/backup" | tr -d ' ')
cp "$work/backup" "$here/backup_$format.backup"
cp -r "$work/data" "$here/journal_new"
echo "backup_$format.backup and journal_new (give it its format's number) are in $here"
