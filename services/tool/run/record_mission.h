// Reads from a store what the page of a report shows.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_
#define CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_

#include <string>

#include "absl/status/statusor.h"
#include "services/client/store/store_reader.h"
#include "services/tool/report/mission_past.h"

namespace corbslam::services {

// Of a past that is longer than six megabytes the present alone, and of a map that is, the past of
// its keyframes. Errors are those of the store; RESOURCE_EXHAUSTED if that is too long, too.
absl::StatusOr<MissionPast> RecordMission(StoreReader& store, const std::string& mission);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_RECORD_MISSION_H_
