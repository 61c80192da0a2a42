#include "map_store/postgres/deleted_rows.h"

#include <utility>
#include <vector>

#include "map_store/postgres/sql_pool.h"
#include "map_store/records/journal.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Each removes some rows of the mission from one table.
constexpr const char* kRemovals[] = {
    "DELETE FROM corbslam.records WHERE (mission_id, position, piece) IN"
    " (SELECT mission_id, position, piece FROM corbslam.records WHERE mission_id = $1 LIMIT 500)",
    "DELETE FROM corbslam.snapshots WHERE (mission_id, generation, piece) IN"
    " (SELECT mission_id, generation, piece FROM corbslam.snapshots WHERE mission_id = $1"
    " LIMIT 500)",
    "DELETE FROM corbslam.keyframes WHERE (mission_id, local_map, keyframe) IN"
    " (SELECT mission_id, local_map, keyframe FROM corbslam.keyframes WHERE mission_id = $1"
    " LIMIT 500)",
    "DELETE FROM corbslam.payloads WHERE (mission_id, hash, piece) IN"
    " (SELECT mission_id, hash, piece FROM corbslam.payloads WHERE mission_id = $1 LIMIT 500)",
    "DELETE FROM corbslam.pictures WHERE (mission_id, local_map, keyframe) IN"
    " (SELECT mission_id, local_map, keyframe FROM corbslam.pictures WHERE mission_id = $1"
    " LIMIT 500)"};

// Sets `found` to whether there was a deleted mission that nobody else works on.
SqlOutcome RemoveSome(SqlConnection& connection, bool& found) {
  const auto fail = [&connection](const absl::Status& status) -> SqlOutcome {
    connection.Rollback();
    return {status};
  };
  const auto picked = connection.Run(
      {{"BEGIN"},
       {"SELECT mission_id FROM corbslam.missions WHERE state = 2 ORDER BY mission_id LIMIT 1"
        " FOR UPDATE SKIP LOCKED"}});
  if (!picked.ok()) return fail(picked.status());
  found = picked->back().rows() > 0;
  if (!found) return connection.Commit({});
  const SqlValue id = SqlValue::Number(picked->back().Number(0, 0));
  SqlStatements removals;
  for (const char* removal : kRemovals) removals.push_back({removal, {id}});
  const auto removed = connection.Run(removals);
  if (!removed.ok()) return fail(removed.status());
  int64_t rows = 0;
  for (const SqlResult& result : *removed) rows += result.changed();
  if (rows > 0) return connection.Commit({});
  return connection.Commit({{"DELETE FROM corbslam.missions WHERE mission_id = $1", {id}}});
}

}  // namespace

absl::Status GiveUpUnfinished(SqlPool& pool) {
  SqlStatements statements = {
      {"UPDATE corbslam.missions SET state = 2 WHERE state = 1"
       " AND made_at < now() - interval '1 day'"}};
  for (const MissionList list : {MissionList::kDeleted, MissionList::kPromised}) {
    statements.push_back(
        {"DELETE FROM corbslam.mission_lists WHERE list = $1 AND noted_at <"
         " (SELECT min(newest.noted_at) FROM (SELECT noted_at FROM corbslam.mission_lists"
         " WHERE list = $1 ORDER BY noted_at DESC LIMIT $2) AS newest)",
         {SqlValue::Number(static_cast<int64_t>(list)),
          SqlValue::Number(int64_t{Journal::kMaxListed})}});
  }
  return pool.WriteAgain(statements).status();
}

absl::Status RemoveDeletedRows(SqlPool& pool, const std::function<bool()>& goes_on) {
  bool found = true;
  while (found && goes_on()) {
    const SqlOutcome outcome =
        pool.Try([&found](SqlConnection& connection) { return RemoveSome(connection, found); });
    RETURN_IF_ERROR(outcome.status);
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
