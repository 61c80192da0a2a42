// Makes rigs of the files that calibration tools and other systems write.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_RIG_CONVERT_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_RIG_CONVERT_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/calibration/yaml_numbers.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

struct RigFiles {
  // One file, or one of each camera, the left one first; or OpenCV's intrinsics and extrinsics.
  std::vector<std::string> paths;
  // One of RigFormats(); empty: found out from what the files hold.
  std::string format;
  // Size of the pictures, for formats that leave it out.
  std::optional<PictureSize> size;
  // What OpenCV's D is of, which its files don't say: "radial-tangential" or "equidistant" (of
  // cv::fisheye). Empty: known by the count of numbers, where that is not 4.
  std::string lens = {};
  bool trust = false;  // Also improbable calibrations are taken.
};

struct ConvertedRig {
  Rig rig;
  std::string format;
  // A sentence for each thing in the files that the rig leaves out, or that is improbable.
  std::vector<std::string> notes;
};

// Returns "kalibr", "ros" and so on.
std::vector<absl::string_view> RigFormats();

// NOT_FOUND where a file can't be opened. INVALID_ARGUMENT names file and field, and what to do
// about it: files of no known format, a field that is missing, a calibration that can't be.
absl::StatusOr<ConvertedRig> ConvertRig(const RigFiles& files);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_RIG_CONVERT_H_
