// The row that says where a mission stands. Whoever writes into the mission locks it first, so that
// writers come one after the other, wherever they run.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_MISSION_ROW_H_
#define CORBSLAM_MAP_STORE_POSTGRES_MISSION_ROW_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "map_store/fleet/lease_rules.h"
#include "map_store/postgres/sql_connection.h"
#include "map_store/postgres/sql_values.h"

namespace corbslam::map_store {

enum class MissionStage : int64_t { kInUse = 0, kBeingMade = 1, kDeleted = 2, kAside = 3 };

// Who writes into missions, from a moment on.
struct MissionHolder {
  int64_t id = 0;  // Drawn by each process.
  std::string name;
  absl::Duration lease;
  // Counts writes that were refused since another process has the mission.
  std::shared_ptr<std::atomic<uint64_t>> refused = std::make_shared<std::atomic<uint64_t>>(0);

  SqlValue LeaseMilliseconds() const { return SqlValue::Number(absl::ToInt64Milliseconds(lease)); }
};

struct MissionRow {
  MissionStage stage = MissionStage::kInUse;
  int64_t format = 0;
  int64_t epoch = 0;
  int64_t holder = 0;
  std::string holder_name = {};
  std::string holder_address = {};  // Empty: not known.
  absl::Duration lease_left = {};   // By the database's clock.
  uint64_t head = 0;                // Position of the last record.
  int64_t head_group = 0;           // Names the transaction that wrote it.
  uint64_t snapshot_position = 0;
  int64_t snapshot_generation = 0;
  uint64_t snapshot_bytes = 0;

  MissionHolding holding() const { return {holder, epoch, lease_left}; }
};

// Returns the checksum of what a mission is put aside with.
uint64_t SummaryChecksum(const std::string& summary);

// Returns a number that nobody else draws; above 0.
int64_t DrawRowId();

// Makes the row of a mission without records. Without a name nobody finds it. Does nothing where
// the id, or the name, is taken.
SqlStatement InsertMissionRow(int64_t id, const std::string* name, MissionStage stage,
                              const MissionHolder& holder);
// Reads the row alone, without a lock.
SqlStatement SelectMissionRow(int64_t id);
// Returns the row; NOT_FOUND: there is none.
absl::StatusOr<MissionRow> MissionRowOf(const SqlResult& result);
// Begins a transaction, runs the statements, and locks the row and reads it. After an error no
// transaction is open.
absl::StatusOr<MissionRow> LockMissionRow(SqlConnection& connection, int64_t id,
                                          const SqlStatements& before = {});

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_MISSION_ROW_H_
