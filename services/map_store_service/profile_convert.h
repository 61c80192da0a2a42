// Converts what people set of a mission to the fields of the contract's Mission and back.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_PROFILE_CONVERT_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_PROFILE_CONVERT_H_

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/resources.pb.h"
#include "google/protobuf/field_mask.pb.h"
#include "map_store/state/mission_profile.h"

namespace corbslam::services {

void ToProto(const map_store::MissionProfile& profile, v1::Mission* proto);
// Reads what can be set; output-only fields are ignored. The values are not checked yet
// (ValidateProfile).
map_store::MissionProfile ProfileFromProto(const v1::Mission& proto);

// Returns INVALID_ARGUMENT for a limit or retention that is asked for and that nothing reaches: a
// negative number of the caller's, most likely. Missions may have such from before.
absl::Status CheckAskedLimits(const v1::Mission& proto,
                              const std::vector<map_store::ProfileField>& fields);

// INVALID_ARGUMENT for a mask that is empty or names what can't be changed.
absl::StatusOr<std::vector<map_store::ProfileField>> FieldsFromProto(
    const google::protobuf::FieldMask& mask);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_PROFILE_CONVERT_H_
