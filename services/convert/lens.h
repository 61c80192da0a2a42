// Turns the lens of a recorded camera into its wire form and back.
#ifndef CORBSLAM_SERVICES_CONVERT_LENS_H_
#define CORBSLAM_SERVICES_CONVERT_LENS_H_

#include "absl/status/statusor.h"
#include "corbslam/v1/geometry.pb.h"
#include "slam/camera/lens.h"

namespace corbslam::services {

// Sets lens_model and distortion.
void LensToProto(const LensModel& model, v1::RecordedCamera* proto);

// INVALID_ARGUMENT names the model or the count of numbers; their values are not checked.
absl::StatusOr<LensModel> LensFromProto(const v1::RecordedCamera& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_LENS_H_
