#include "client_agent/agent/resuming.h"

#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/upload/spooled_map_reading.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Poses are rounded where they are written.
constexpr double kRounding = 1e-5;

std::string Describe(const Camera& camera) {
  return absl::StrCat("f ", camera.fx_px, ", ", camera.fy_px, ", c ", camera.cx_px, ", ",
                      camera.cy_px, ", ", camera.width_px, "x", camera.height_px, ", baseline ",
                      camera.baseline_m);
}

bool AreAlike(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.angularDistance(b.rotation) < kRounding &&
         (a.translation - b.translation).norm() < kRounding;
}

bool AreAlike(const RecordedCamera& a, const RecordedCamera& b) {
  if (!(a.lens == b.lens) || !AreAlike(a.camera_from_recorded, b.camera_from_recorded)) {
    return false;
  }
  if (a.body_from_recorded.has_value() != b.body_from_recorded.has_value()) return false;
  return !a.body_from_recorded.has_value() ||
         AreAlike(*a.body_from_recorded, *b.body_from_recorded);
}

}  // namespace

absl::Status CheckSameRig(const SpooledMap& spooled_map, const Camera& camera,
                          const RecordedCamera& recorded) {
  for (size_t i = 0; i < spooled_map.cameras().size(); ++i) {
    if (!(*spooled_map.cameras()[i] == camera)) {
      return absl::FailedPreconditionError(absl::StrCat(
          "local map ", ToString(spooled_map.local_map()), " was made with another camera (",
          Describe(*spooled_map.cameras()[i]), "; now ", Describe(camera), ")"));
    }
    const std::optional<RecordedCamera>& before = spooled_map.recorded_cameras()[i];
    if (before.has_value() && !AreAlike(*before, recorded)) {
      return absl::FailedPreconditionError(
          absl::StrCat("local map ", ToString(spooled_map.local_map()),
                       " was made with another rig: the lens, or how the camera is mounted or "
                       "rectified, is not as it was"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<SpooledMap> FindMapToResume(Spool& spool, const Camera& camera,
                                           const RecordedCamera& recorded) {
  ASSIGN_OR_RETURN(SpooledMap spooled_map, ReadNewestSpooledMap(spool));
  RETURN_IF_ERROR(CheckSameRig(spooled_map, camera, recorded));
  return spooled_map;
}

}  // namespace corbslam::client_agent
