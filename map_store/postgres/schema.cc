#include "map_store/postgres/schema.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "map_store/postgres/sql_pool.h"
#include "slam/util/program_version.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// A later version is a block of its own behind this one, which changes what this one made and adds
// its row to schema_versions.
constexpr char kVersion1[] = R"sql(
CREATE SCHEMA IF NOT EXISTS corbslam;

-- The versions that were brought in. A program works with these tables if it knows a version of at
-- least the newest row's oldest_program.
CREATE TABLE IF NOT EXISTS corbslam.schema_versions (
  version bigint PRIMARY KEY,
  oldest_program bigint NOT NULL
);

-- A mission: state 0 in use, 1 being made, 2 deleted, 3 aside. head is the position of its last
-- record, and head_group names the transaction that wrote it. Who writes has the epoch, and the
-- holder's name is for people; until lease_until, by this database's clock, nobody else takes it.
CREATE TABLE IF NOT EXISTS corbslam.missions (
  mission_id bigint PRIMARY KEY,
  name text UNIQUE,
  state bigint NOT NULL,
  format bigint NOT NULL,
  epoch bigint NOT NULL,
  holder bigint NOT NULL,
  holder_name text NOT NULL,
  lease_until timestamptz,
  head bigint NOT NULL,
  head_group bigint NOT NULL,
  snapshot_position bigint NOT NULL,
  snapshot_generation bigint NOT NULL,
  snapshot_bytes bigint NOT NULL,
  bytes bigint NOT NULL,
  summary bytea,
  summary_checksum bigint,
  made_at timestamptz NOT NULL DEFAULT now()
);

CREATE TABLE IF NOT EXISTS corbslam.records (
  mission_id bigint NOT NULL,
  position bigint NOT NULL,
  piece bigint NOT NULL,
  pieces bigint NOT NULL,
  checksum bigint NOT NULL,
  bytes bytea NOT NULL,
  PRIMARY KEY (mission_id, position, piece)
);

CREATE TABLE IF NOT EXISTS corbslam.snapshots (
  mission_id bigint NOT NULL,
  generation bigint NOT NULL,
  piece bigint NOT NULL,
  pieces bigint NOT NULL,
  checksum bigint NOT NULL,
  bytes bytea NOT NULL,
  PRIMARY KEY (mission_id, generation, piece)
);

-- Which features a keyframe has, by the SHA-256 of their bytes, and with which record they came.
CREATE TABLE IF NOT EXISTS corbslam.keyframes (
  mission_id bigint NOT NULL,
  local_map bigint NOT NULL,
  keyframe bigint NOT NULL,
  position bigint NOT NULL,
  hash bytea NOT NULL,
  size bigint NOT NULL,
  PRIMARY KEY (mission_id, local_map, keyframe)
);
CREATE INDEX IF NOT EXISTS keyframes_by_hash ON corbslam.keyframes (mission_id, hash);

CREATE TABLE IF NOT EXISTS corbslam.payloads (
  mission_id bigint NOT NULL,
  hash bytea NOT NULL,
  piece bigint NOT NULL,
  bytes bytea NOT NULL,
  PRIMARY KEY (mission_id, hash, piece)
);

CREATE TABLE IF NOT EXISTS corbslam.pictures (
  mission_id bigint NOT NULL,
  local_map bigint NOT NULL,
  keyframe bigint NOT NULL,
  ordinal bigint NOT NULL,
  scale bigint NOT NULL,
  size bigint NOT NULL,
  checksum bigint NOT NULL,
  bytes bytea NOT NULL,
  PRIMARY KEY (mission_id, local_map, keyframe)
);
CREATE INDEX IF NOT EXISTS pictures_by_ordinal ON corbslam.pictures (mission_id, ordinal);

-- Missions that were (list 0: deleted, list 1: promised to a robot).
CREATE TABLE IF NOT EXISTS corbslam.mission_lists (
  list bigint NOT NULL,
  noted_at timestamptz NOT NULL DEFAULT now(),
  entry_id bigint NOT NULL,
  name text NOT NULL,
  uid text NOT NULL,
  PRIMARY KEY (list, noted_at, entry_id)
);

INSERT INTO corbslam.schema_versions (version, oldest_program) VALUES (1, 1)
  ON CONFLICT (version) DO NOTHING;
)sql";

// Programs of version 1 neither read nor write what this adds.
constexpr char kVersion2[] = R"sql(
-- A store that shares the missions with others: the process that is it (holder, as in missions),
-- and where it is reached. Until lease_until it counts as alive. A cordoned one (1) takes no more
-- missions.
CREATE TABLE IF NOT EXISTS corbslam.stores (
  name text PRIMARY KEY,
  holder bigint NOT NULL,
  address text NOT NULL,
  machine text NOT NULL,
  version text NOT NULL,
  lease_until timestamptz,
  cordoned bigint NOT NULL DEFAULT 0,
  started_at timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX IF NOT EXISTS stores_by_holder ON corbslam.stores (holder);
-- The store that is to have the mission; null: whichever is asked first.
ALTER TABLE corbslam.missions ADD COLUMN IF NOT EXISTS wanted_store text;

INSERT INTO corbslam.schema_versions (version, oldest_program) VALUES (2, 1)
  ON CONFLICT (version) DO NOTHING;
)sql";

// Programs of older versions leave out what this adds.
constexpr char kVersion3[] = R"sql(
-- How much a store had to do when it last said so, with its lease until load_until: processors and
-- those of them that are busy in thousandths, memory, keyframes in a thousand seconds, requests to
-- fusion workers that wait, and the workers that it offers to all. When a mission last went from it
-- or to it to balance loads.
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS load_until timestamptz;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS busy_milli bigint;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS processors_milli bigint;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS resident_bytes bigint;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS budget_bytes bigint;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS keyframes_milli bigint;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS waiting_requests bigint;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS workers text;
ALTER TABLE corbslam.stores ADD COLUMN IF NOT EXISTS balanced_at timestamptz;
-- When a store last gave the mission to another one.
ALTER TABLE corbslam.missions ADD COLUMN IF NOT EXISTS moved_at timestamptz;
CREATE INDEX IF NOT EXISTS missions_by_holder ON corbslam.missions (holder);

INSERT INTO corbslam.schema_versions (version, oldest_program) VALUES (3, 1)
  ON CONFLICT (version) DO NOTHING;
)sql";

constexpr char kRights[] = R"sql(
-- The role of map_store reads and writes rows; it makes, changes and drops no table.
GRANT USAGE ON SCHEMA corbslam TO ROLE_NAME;
GRANT SELECT ON corbslam.schema_versions TO ROLE_NAME;
GRANT SELECT, INSERT, UPDATE, DELETE ON corbslam.missions, corbslam.records, corbslam.snapshots,
  corbslam.keyframes, corbslam.payloads, corbslam.pictures, corbslam.mission_lists,
  corbslam.stores TO ROLE_NAME;
)sql";

constexpr char kHowToMake[] =
    "run what `corbslam store-schema` prints in that database, as the one who owns it "
    "(docs/fleet.md)";

bool IsRoleName(const std::string& role) {
  return !role.empty() && !std::isdigit(static_cast<unsigned char>(role[0])) &&
         std::all_of(role.begin(), role.end(), [](char letter) {
           return (letter >= 'a' && letter <= 'z') || (letter >= '0' && letter <= '9') ||
                  letter == '_';
         });
}

}  // namespace

absl::StatusOr<std::string> MakeSchemaSql(const std::string& role) {
  if (!IsRoleName(role)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the role \"", role, "\" is to be of lower-case letters, digits and underscores"));
  }
  return absl::StrCat("-- Tables of map_store --journal postgres:URI, version ", kSchemaVersion,
                      "; by corbslam ", CorbslamVersion(), ".", kVersion1, kVersion2, kVersion3,
                      absl::StrReplaceAll(kRights, {{"ROLE_NAME", role}}));
}

absl::Status CheckSchema(SqlPool& pool) {
  const auto read = pool.Read(
      {{"SELECT version, oldest_program FROM corbslam.schema_versions ORDER BY version DESC"
        " LIMIT 1"}});
  if (absl::IsFailedPrecondition(read.status()) || (read.ok() && read->front().rows() == 0)) {
    const std::string said = read.ok() ? pool.name() : std::string(read.status().message());
    return absl::FailedPreconditionError(
        absl::StrCat(said, ": the journal's tables can't be used: ", kHowToMake));
  }
  RETURN_IF_ERROR(read.status());
  const int64_t version = read->front().Number(0, 0);
  const int64_t oldest = read->front().Number(0, 1);
  if (version < kSchemaVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat(pool.name(), ": its tables are of version ", version, ", and this program (",
                     CorbslamVersion(), ") needs version ", kSchemaVersion, ": ", kHowToMake));
  }
  if (oldest > kSchemaVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat(pool.name(), ": its tables are of version ", version,
                     ", which takes programs that know ", oldest, " or more; this one (",
                     CorbslamVersion(), ") knows ", kSchemaVersion, ": start a newer program"));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
