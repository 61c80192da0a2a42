#include "client_agent/tracking/camera_doubt.h"

#include <glog/logging.h>

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/tracking/frame_evidence.h"

namespace corbslam::client_agent {
namespace {

std::string Describe(const Camera& camera) {
  return absl::StrFormat("fx %.1f fy %.1f cx %.1f cy %.1f px, baseline %.4f m", camera.fx_px,
                         camera.fy_px, camera.cx_px, camera.cy_px, camera.baseline_m);
}

}  // namespace

bool CameraDoubt::BelievesFound(const Frame& frame, const std::vector<PointInView>& points) {
  frames_ = 0;
  return HasExpectedCamera(frame, points);
}

bool CameraDoubt::BelievesTracked(const Frame& frame, const std::vector<PointInView>& points) {
  if (++frames_ % kEachFrames != 0) return true;
  return HasExpectedCamera(frame, points) || in_a_row_ < kEnough;
}

bool CameraDoubt::HasExpectedCamera(const Frame& frame, const std::vector<PointInView>& points) {
  const FrameEvidence evidence(frame, points);
  const CameraCheck check = evidence.CheckCamera();
  if (check.verdict != CameraCheck::Verdict::kAnother && !check.gains) {
    in_a_row_ = 0;
    return true;
  }
  ++in_a_row_;
  if (in_a_row_ >= kEnough) Warn(frame.camera(), *check.fit);
  return false;
}

void CameraDoubt::Warn(const Camera& said, const CameraFit& fit) {
  if (has_warned_) return;
  has_warned_ = true;
  LOG(WARNING)
      << "the pictures fit what others mapped with another camera than the rig's: the rig "
         "says "
      << Describe(said) << ", they fit " << Describe(fit.camera)
      << absl::StrFormat(" and a lens that moves its edge by %.1f %%",
                         100 * std::abs(fit.radial.value))
      << ". With the rig's the poses would be wrong, and none is given: is it this robot's "
         "calibration, of this picture size? (docs/rig.md)";
}

}  // namespace corbslam::client_agent
