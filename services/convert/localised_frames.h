// Converts where frames were of an agent that changes nothing, to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_LOCALISED_FRAMES_H_
#define CORBSLAM_SERVICES_CONVERT_LOCALISED_FRAMES_H_

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/map_update.pb.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

void ToProto(std::span<const LocalisedFrame> frames, v1::LocalisedFrames* proto);
// INVALID_ARGUMENT names the frame, the field and its limits.
absl::StatusOr<std::vector<LocalisedFrame>> FromProto(const v1::LocalisedFrames& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_LOCALISED_FRAMES_H_
