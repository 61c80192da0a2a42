#include "client_agent/upload/spooled_map_reading.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using Kind = SpoolRecord::Kind;

// Returns the records of the last snapshot that is complete; empty: there is none.
std::vector<SpooledBatch> FindSnapshot(const std::vector<SpooledBatch>& records) {
  std::vector<SpooledBatch> snapshot;
  std::vector<SpooledBatch> parts;
  for (const SpooledBatch& spooled : records) {
    const SpoolRecord& record = spooled.record;
    if (record.kind != Kind::kSnapshotPart && record.kind != Kind::kSnapshotEnd) continue;
    if (!parts.empty() && parts.back().record.number != record.number) parts.clear();
    parts.push_back(spooled);
    if (record.kind == Kind::kSnapshotEnd) snapshot = std::exchange(parts, {});
  }
  return snapshot;
}

absl::Status ApplyRecord(const SpooledBatch& spooled, const ReadSpooled& read,
                         SpooledMap& spooled_map) {
  ASSIGN_OR_RETURN(const MapUpdateBatch batch, read(spooled));
  const absl::Status applied = spooled_map.Apply(batch);
  if (applied.ok()) return applied;
  return absl::Status(applied.code(),
                      absl::StrCat("batch ", spooled.record.number, ": ", applied.message()));
}

}  // namespace

absl::StatusOr<SpooledMap> ReadSpooledMap(LocalMapId local_map,
                                          const std::vector<SpooledBatch>& records,
                                          const ReadSpooled& read) {
  SpooledMap spooled_map(local_map);
  uint64_t last = 0;
  for (const SpooledBatch& part : FindSnapshot(records)) {
    RETURN_IF_ERROR(ApplyRecord(part, read, spooled_map));
    last = part.record.number;
  }
  for (const SpooledBatch& spooled : records) {
    if (spooled.record.kind != Kind::kBatch || spooled.record.number <= last) continue;
    if (spooled.record.number != last + 1) {
      return absl::FailedPreconditionError(absl::StrCat(
          "the spool has no batch ", last + 1, " of it, but batch ", spooled.record.number,
          last == 0 ? ": the robot that made it did not run with --resume" : ""));
    }
    RETURN_IF_ERROR(ApplyRecord(spooled, read, spooled_map));
    last = spooled.record.number;
  }
  RETURN_IF_ERROR(spooled_map.Check());
  return spooled_map;
}

absl::StatusOr<SpooledMap> ReadNewestSpooledMap(Spool& spool) {
  std::vector<LocalMapId> in_order;
  std::set<LocalMapId> closed;
  for (const SpooledBatch& spooled : spool.found()) {
    const LocalMapId id = spooled.record.local_map;
    if (std::ranges::find(in_order, id) == in_order.end()) in_order.push_back(id);
    if (spooled.record.closes_local_map) closed.insert(id);
  }
  std::optional<LocalMapId> newest;
  for (const LocalMapId id : in_order) {
    if (!closed.contains(id)) newest = id;
  }
  if (!newest.has_value()) return absl::NotFoundError("the spool has no local map that is open");
  std::vector<SpooledBatch> records = spool.found();
  std::erase_if(records,
                [&](const SpooledBatch& spooled) { return spooled.record.local_map != *newest; });
  absl::StatusOr<SpooledMap> spooled_map = ReadSpooledMap(
      *newest, records, [&](const SpooledBatch& spooled) { return spool.Read(spooled); });
  if (spooled_map.ok()) return spooled_map;
  return absl::Status(
      spooled_map.status().code(),
      absl::StrCat("local map ", ToString(*newest), ": ", spooled_map.status().message()));
}

}  // namespace corbslam::client_agent
