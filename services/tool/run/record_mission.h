// Reads from a store what the page of a report shows.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_
#define CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "services/client/store/store_reader.h"
#include "services/tool/report/mission_past.h"

namespace corbslam::services {

// A longer map is recorded in part. In the page each byte takes four thirds of one.
inline constexpr size_t kMostRecordedBytes = 6'000'000;

// Records a mission whose run is over: nobody is connected any more. With `has_journal` the store
// can tell the map's past, which is recorded, too. Of a map that is longer than `most_bytes` the
// first of these is recorded that is not: the past, the present, the past without points, the
// present without points. RESOURCE_EXHAUSTED if none is short enough; other errors are the store's.
absl::StatusOr<MissionPast> RecordMission(StoreReader& store, const std::string& mission,
                                          bool has_journal, size_t most_bytes = kMostRecordedBytes);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_
