// Converts what an agent says that changes nothing, to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_LOCALISED_FRAMES_H_
#define CORBSLAM_SERVICES_CONVERT_LOCALISED_FRAMES_H_

#include "absl/status/statusor.h"
#include "corbslam/v1/map_update.pb.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

void ToProto(const LocalisedFrames& localised, v1::LocalisedFrames* proto);
// INVALID_ARGUMENT names the frame, the field and its limits.
absl::StatusOr<LocalisedFrames> FromProto(const v1::LocalisedFrames& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_LOCALISED_FRAMES_H_
