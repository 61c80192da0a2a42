#!/bin/bash
# Makes roles, tables and rights of a fleet's database (compose.fleet.yaml), once, as its
# administrator. Nothing here waits for standbys: PGOPTIONS says so, as there are none yet.
set -eu
secrets=${SECRETS:-/run/secrets}
psql -v ON_ERROR_STOP=1 --username "$POSTGRES_USER" --dbname "$POSTGRES_DB" \
  -v database_password="$(cat "$secrets/database_password")" \
  -v replication_password="$(cat "$secrets/replication_password")" <<'SQL'
CREATE ROLE corbslam LOGIN PASSWORD :'database_password';
CREATE ROLE replicator REPLICATION LOGIN PASSWORD :'replication_password';
-- Stores then see which standbys commits wait for (corbslam_database_standbys_there).
GRANT pg_read_all_stats TO corbslam;
SQL
psql -v ON_ERROR_STOP=1 --username "$POSTGRES_USER" --dbname "$POSTGRES_DB" -f "$secrets/schema.sql"
echo "host replication replicator all scram-sha-256" >> "$PGDATA/pg_hba.conf"
