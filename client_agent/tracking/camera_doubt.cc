#include "client_agent/tracking/camera_doubt.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace corbslam::client_agent {
namespace {

std::string Describe(const Camera& camera) {
  return absl::StrFormat("fx %.1f fy %.1f cx %.1f cy %.1f px, baseline %.4f m", camera.fx_px,
                         camera.fy_px, camera.cx_px, camera.cy_px, camera.baseline_m);
}

}  // namespace

void CameraDoubt::Look(const Frame& frame) {
  if (has_warned_ || ++frames_ % kEachFrames != 0) return;
  const std::optional<CameraFit> fit = FitFrameCamera(frame);
  if (!fit.has_value()) return;
  looks_.push_back(IsAnotherCamera(*fit));
  if (looks_.size() > kLooks) looks_.pop_front();
  if (std::ranges::count(looks_, true) < kEnough) return;
  has_warned_ = true;
  LOG(WARNING) << "the pictures fit what others mapped with another camera than the rig's: the rig "
                  "says "
               << Describe(frame.camera()) << ", they fit " << Describe(fit->camera)
               << absl::StrFormat(" and a lens that moves its edge by %.1f %%",
                                  100 * std::abs(fit->radial.value))
               << ". Poses are wrong by what these differ: is it this robot's calibration, of this "
                  "picture size? (docs/rig.md)";
}

}  // namespace corbslam::client_agent
