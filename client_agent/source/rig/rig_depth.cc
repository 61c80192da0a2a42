#include "client_agent/source/rig/rig_depth.h"

#include <opencv2/core.hpp>
#include <utility>

#include "absl/strings/str_format.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

DepthGeometry DepthGeometryOf(const Rig& rig) {
  const RigCamera& colour = rig.cameras[0];
  const RigCamera& depth = *rig.depth.camera;
  return {depth.raw,
          {depth.width_px, depth.height_px},
          colour.raw,
          {colour.width_px, colour.height_px},
          rig.depth.colour_from_depth};
}

absl::StatusOr<DepthPreparation> DepthPreparation::Make(const Rig& rig,
                                                        std::optional<bool> registers) {
  if (rig.kind != RigKind::kRgbd) {
    return absl::InvalidArgumentError("depth is of RGB-D rigs, this one is a stereo pair");
  }
  RETURN_IF_ERROR(Validate(rig));
  const bool has_camera = rig.depth.camera.has_value();
  if (registers.value_or(false) && !has_camera) {
    return absl::InvalidArgumentError(
        "to register depth, the rig must say through which lens it is measured (depth.camera) and "
        "where that camera sits (depth.colour_from_depth); leave register=1 out where the device "
        "registers it");
  }
  DepthPreparation preparation;
  preparation.units_per_m_ = rig.depth.units_per_m;
  preparation.no_depth_ = rig.depth.no_depth;
  if (!registers.value_or(has_camera)) return preparation;
  ASSIGN_OR_RETURN(DepthRegistration registration, DepthRegistration::Make(DepthGeometryOf(rig)));
  preparation.registration_ = std::make_shared<const DepthRegistration>(std::move(registration));
  preparation.raw_size_ = cv::Size(rig.depth.camera->width_px, rig.depth.camera->height_px);
  preparation.description_ = absl::StrFormat(
      "registered from a camera of %dx%d, %.1f mm beside", rig.depth.camera->width_px,
      rig.depth.camera->height_px, 1000 * rig.depth.colour_from_depth.translation.norm());
  return preparation;
}

absl::StatusOr<cv::Mat> DepthPreparation::Prepare(const cv::Mat& depth) const {
  cv::Mat valid = depth;
  if (!no_depth_.empty()) {
    valid = depth.clone();
    for (const double value : no_depth_) valid.setTo(0, depth == value);
  }
  if (registration_ == nullptr) return valid;
  return registration_->Register(valid, units_per_m_);
}

}  // namespace corbslam::client_agent
