#!/bin/bash
# Runs a standby of a fleet's database (compose.fleet.yaml), under the name STANDBY by which commits
# wait for it: the first time with a copy of the primary.
set -eu
: "${PGDATA:=/var/lib/postgresql/data}" "${PRIMARY:=database}" "${PRIMARY_PORT:=5432}"
secrets=${SECRETS:-/run/secrets}
PGPASSWORD=$(cat "$secrets/replication_password")
export PGPASSWORD
until [ -e "$PGDATA/standby.signal" ] || [ -e "$PGDATA/PG_VERSION" ]; do
  # What an attempt that was broken off has left is no copy.
  find "$PGDATA" -mindepth 1 -delete
  pg_basebackup -X stream -R -D "$PGDATA" \
    -d "host=$PRIMARY port=$PRIMARY_PORT user=replicator application_name=$STANDBY" || sleep 2
done
chmod 0700 "$PGDATA"
exec postgres "$@"
