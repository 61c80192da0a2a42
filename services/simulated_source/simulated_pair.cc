#include "services/simulated_source/simulated_pair.h"

#include <variant>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::CalibrationOf;
using client_agent::ReadRigFile;
using client_agent::Rig;
using client_agent::RigKind;

bool IsFile(absl::string_view value) {
  return absl::StrContains(value, '/') || absl::StrContains(value, '.');
}

absl::StatusOr<SimulatedPair> ReadSimulatedPair(const std::string& path) {
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(path));
  if (rig.kind != RigKind::kStereo) {
    return absl::InvalidArgumentError(absl::StrCat(
        path,
        ": only stereo pairs are simulated from a rig file; RGB-D is rig=rgbd, and one "
        "camera alone is the first of any with cameras=1"));
  }
  if (rig.cameras[0].width_px != rig.cameras[1].width_px ||
      rig.cameras[0].height_px != rig.cameras[1].height_px) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": size_px of both cameras must be the same"));
  }
  ASSIGN_OR_RETURN(const SensorCalibration told, CalibrationOf(rig));
  SimulatedPair pair;
  pair.file = path;
  pair.told = std::get<StereoCalibration>(told);
  pair.left = rig.cameras[0].raw;
  pair.right = rig.cameras[1].raw;
  pair.right_from_left = rig.right_from_left;
  if (rig.rectified) {
    pair.right_from_left = {Eigen::Quaterniond::Identity(), {-rig.baseline_m, 0, 0}};
  }
  pair.width_px = rig.cameras[0].width_px;
  pair.height_px = rig.cameras[0].height_px;
  pair.rate_hz = rig.rate_hz.value_or(0);
  return pair;
}

}  // namespace corbslam::services
