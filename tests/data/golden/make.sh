#!/bin/sh
# make.sh PROGRAMS FORMAT: makes a backup, a journal's folder (of this format), its robot's poses and a
# robot's spool with the programs in PROGRAMS; see README.md.
set -eu

programs=$(cd "$1" && pwd)
journal=journal_$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
store=
trap '[ -z "$store" ] || kill "$store"; rm -rf "$work"' EXIT

# Robots had the simulator in them at first.
robot=$programs/simulated_agent
[ -x "$robot" ] || robot=$programs/client_agent

"$programs/map_store" --listen 127.0.0.1:0 --data-dir "$work/data" --insecure \
  > "$work/store.log" 2>&1 &
store=$!
address=
for _ in $(seq 600); do
  address=$(sed -n 's/^listening on //p' "$work/store.log")
  [ -z "$address" ] || break
  sleep 0.1
done
"$robot" --source "sim:city?seed=7&frames=0:9" --features 1000 --insecure \
  --server "$address" --mission golden --agent alpha > "$work/agent.log" 2>&1 ||
  { cat "$work/agent.log" >&2; exit 1; }
"$programs/corbslam" mission list --insecure --server "$address"
"$programs/corbslam" mission backup --insecure --server "$address" --mission golden \
  --out "$work/backup"
# The first programs knew no other camera than the rectified one.
of=
if "$programs/corbslam" mission export --help | grep -q -- --poses-of; then of="--poses-of rectified"; fi
# shellcheck disable=SC2086
"$programs/corbslam" mission export --insecure --server "$address" --mission golden --format tum \
  --agent alpha $of --out "$work/poses"
kill "$store"
wait "$store" || true
store=

# Nobody listens there: all stays in the spool, and the robot says so.
"$robot" --source "sim:city?seed=7&frames=0:9" --features 600 --insecure --server 127.0.0.1:1 \
  --mission golden --agent alpha --spool-dir "$work/spool" --outbox-mb 0 --finish 3 \
  > "$work/spool.log" 2>&1 || true

# A backup has its format in bytes 8 to 11, a file of the spool as a digit in byte 7.
backup=backup_$(od -An -tu4 -j8 -N4 "$work/backup" | tr -d ' ').backup
spool=spool_$(head -c 8 "$work/spool"/0* | tail -c 1)
cp "$work/backup" "$here/$backup"
cp "$work/poses" "$here/$backup.poses"
rm -rf "$here/$journal" "$here/$spool"
cp -r "$work/data" "$here/$journal"
cp "$work/poses" "$here/$journal.poses"
cp -r "$work/spool" "$here/$spool"
echo "$backup, $journal and $spool are in $here"
