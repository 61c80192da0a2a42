#include "map_store/postgres/mission_row.h"

#include <random>
#include <utility>
#include <vector>

#include "map_store/archive/formats.h"
#include "map_store/postgres/pieces.h"

namespace corbslam::map_store {
namespace {

constexpr char kSelect[] =
    "SELECT state, format, epoch, head, head_group, snapshot_position, snapshot_generation,"
    " snapshot_bytes, holder, holder_name,"
    " coalesce(ceil(extract(epoch FROM lease_until - clock_timestamp()) * 1000), 0)::bigint,"
    " (SELECT address FROM corbslam.stores WHERE stores.holder = missions.holder LIMIT 1)"
    " FROM corbslam.missions WHERE mission_id = $1";
constexpr char kSelectForUpdate[] =
    "SELECT state, format, epoch, head, head_group, snapshot_position, snapshot_generation,"
    " snapshot_bytes, holder, holder_name,"
    " coalesce(ceil(extract(epoch FROM lease_until - clock_timestamp()) * 1000), 0)::bigint,"
    " (SELECT address FROM corbslam.stores WHERE stores.holder = missions.holder LIMIT 1)"
    " FROM corbslam.missions WHERE mission_id = $1 FOR UPDATE";

// Of checksums, a place that is no position.
constexpr uint64_t kSummaryPlace = ~uint64_t{0};

}  // namespace

uint64_t SummaryChecksum(const std::string& summary) {
  return ChecksumOf(Piece{0, 1, 0, summary}, kSummaryPlace);
}

int64_t DrawRowId() {
  std::random_device random;
  const uint64_t drawn = (uint64_t{random()} << 32) | random();
  return static_cast<int64_t>(drawn >> 1) | 1;
}

SqlStatement InsertMissionRow(int64_t id, const std::string* name, MissionStage stage,
                              const MissionHolder& holder) {
  return {
      "INSERT INTO corbslam.missions (mission_id, name, state, format, epoch, holder,"
      " holder_name, head, head_group, snapshot_position, snapshot_generation, snapshot_bytes,"
      " bytes) VALUES ($1, $2, $3, $4, 1, $5, $6, 0, 0, 0, 0, 0, 0) ON CONFLICT DO NOTHING",
      {SqlValue::Number(id), name == nullptr ? SqlValue::Null() : SqlValue::Text(*name),
       SqlValue::Number(static_cast<int64_t>(stage)), SqlValue::Number(kJournalFormat),
       SqlValue::Number(holder.id), SqlValue::Text(holder.name)}};
}

SqlStatement SelectMissionRow(int64_t id) { return {kSelect, {SqlValue::Number(id)}}; }

absl::StatusOr<MissionRow> MissionRowOf(const SqlResult& result) {
  if (result.rows() == 0) return absl::NotFoundError("its row is not there");
  MissionRow row;
  row.stage = static_cast<MissionStage>(result.Number(0, 0));
  row.format = result.Number(0, 1);
  row.epoch = result.Number(0, 2);
  row.head = result.Bits(0, 3);
  row.head_group = result.Number(0, 4);
  row.snapshot_position = result.Bits(0, 5);
  row.snapshot_generation = result.Number(0, 6);
  row.snapshot_bytes = result.Bits(0, 7);
  row.holder = result.Number(0, 8);
  row.holder_name = result.Text(0, 9);
  row.lease_left = absl::Milliseconds(result.Number(0, 10));
  row.holder_address = result.Text(0, 11);
  return row;
}

absl::StatusOr<MissionRow> LockMissionRow(SqlConnection& connection, int64_t id,
                                          const SqlStatements& before) {
  SqlStatements statements = {{"BEGIN"}};
  statements.insert(statements.end(), before.begin(), before.end());
  statements.push_back({kSelectForUpdate, {SqlValue::Number(id)}});
  const absl::StatusOr<std::vector<SqlResult>> results = connection.Run(statements);
  absl::StatusOr<MissionRow> row =
      results.ok() ? MissionRowOf(results->back()) : absl::StatusOr<MissionRow>(results.status());
  if (!row.ok()) connection.Rollback();
  return row;
}

}  // namespace corbslam::map_store
