// Reads from a store what the page of a report shows.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_
#define CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "services/client/store/store_reader.h"
#include "services/tool/report/shown_mission.h"

namespace corbslam::services {

// A longer map is recorded in part. In the page each byte takes four thirds of one.
inline constexpr size_t kMostRecordedBytes = 6'000'000;

// What is recorded.
struct RecordOptions {
  // Their run is over: whose session still stands has finished. Others are as the store has them.
  std::vector<std::string> robots = {};
  // The store can tell the map's past, which is recorded, too.
  bool has_journal = false;
  size_t most_bytes = kMostRecordedBytes;
};

// Records a mission. Of a map that is longer than `most_bytes` the first of these is recorded that
// is not: the past, the present, the past without points, the present without points.
// RESOURCE_EXHAUSTED if none is short enough; other errors are the store's.
absl::StatusOr<ShownMission> RecordMission(StoreReader& store, const std::string& mission,
                                           const RecordOptions& options);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_
