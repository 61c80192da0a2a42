// Says what of a bag is played, and what its messages leave open.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_OPTIONS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_OPTIONS_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

struct BagOptions {
  std::string path;
  // left=TOPIC, right=TOPIC, depth=TOPIC: what is played. An RGB-D camera's picture is `left`.
  // Empty: found out.
  std::string left;
  std::string right;
  std::string depth;
  // left_info=TOPIC and so on: their CameraInfo. Empty: found out.
  std::string left_info;
  std::string right_info;
  std::string depth_info;
  // imu=TOPIC: what an IMU measured. "0": it is played without. Empty: found out.
  std::string imu;
  std::string rig_file;  // rig=FILE: instead of any CameraInfo. Empty: none.
  // time=recording: times are the recorder's; time=header: the messages' own.
  bool by_recording_time = false;
  double scale = 1;
  bool trust_calibration = false;
  std::optional<double> pair_within_ms;     // 2 of a stereo pair, 20 of depth.
  std::optional<double> depth_units_per_m;  // Of 16 bits; 1000 (REP 118).
  std::optional<bool> registers;            // register=1, register=0.
};

// Returns the names of the options, spelled with '_'.
std::vector<absl::string_view> BagOptionNames();
// INVALID_ARGUMENT names the option, its value and what it wants.
absl::Status ApplyBagOption(absl::string_view key, absl::string_view value, BagOptions& options);
// INVALID_ARGUMENT where topics are named that make no rig.
absl::Status Validate(const BagOptions& options);
// Returns name and value of the options that differ from their defaults.
std::vector<std::pair<std::string, std::string>> FormatBagOptions(const BagOptions& options);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_OPTIONS_H_
