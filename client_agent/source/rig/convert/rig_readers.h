// Reads rigs, one format each. Internal to the converter: use ConvertRig.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_RIG_READERS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_RIG_READERS_H_

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/rig/convert/rig_convert.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// They fill in `rig` and `notes`. Kalibr's camchain.yaml or camchain-imucam.yaml,
// and its imu.yaml.
absl::StatusOr<ConvertedRig> ReadKalibr(const RigFiles& files);
// ROS's camera_info YAML of the left and the right camera, as camera_calibration writes them.
absl::StatusOr<ConvertedRig> ReadRosPair(const RigFiles& files);
// OpenCV's stereo calibration: M1, D1, M2, D2 and R, T, in one file or two.
absl::StatusOr<ConvertedRig> ReadOpenCvStereo(const RigFiles& files);
// The settings of ORB-SLAM2 and ORB-SLAM3, for stereo and RGB-D.
absl::StatusOr<ConvertedRig> ReadOrbSlam(const RigFiles& files);
// Basalt's calibration.json.
absl::StatusOr<ConvertedRig> ReadBasalt(const RigFiles& files);
// SVO's (rpg_svo_pro) calibration: cameras with T_B_C.
absl::StatusOr<ConvertedRig> ReadSvo(const RigFiles& files);
// OKVIS2's configuration: cameras with T_SC.
absl::StatusOr<ConvertedRig> ReadOkvis2(const RigFiles& files);
// stella_vslam's configuration, for stereo and RGB-D.
absl::StatusOr<ConvertedRig> ReadStellaVslam(const RigFiles& files);
// VINS-Fusion's configuration, and the cameras' files that it names.
absl::StatusOr<ConvertedRig> ReadVinsFusion(const RigFiles& files);
// EuRoC's cam0/sensor.yaml and cam1/sensor.yaml, and imu0/sensor.yaml, or their recording's folder.
absl::StatusOr<ConvertedRig> ReadEurocPair(const RigFiles& files);
// KITTI's calib.txt (odometry) or calib_cam_to_cam.txt (raw): the grey pair.
absl::StatusOr<ConvertedRig> ReadKittiPair(const RigFiles& files);

// INVALID_ARGUMENT says how many files the format wants, unless it is given `count`.
absl::Status ExpectFiles(const RigFiles& files, size_t count, absl::string_view what);

// Reads a rig that is one YAML file, by `read`; `what` says for people which file the format wants.
absl::StatusOr<ConvertedRig> ReadOneFile(
    const RigFiles& files, absl::string_view what,
    absl::FunctionRef<absl::Status(const YAML::Node& file, const std::string& path,
                                   ConvertedRig& converted)>
        read);

// Returns whose a calibration is that can't be read, and what to do about it, by how its text
// begins; "" for any other.
std::string DescribeForeignCalibration(absl::string_view text);

// INVALID_ARGUMENT names file and field, unless the nine numbers are those of a camera matrix by
// its rows, without skew, which no rig has.
absl::Status CheckCameraMatrix(const std::vector<double>& k, const std::string& path,
                               absl::string_view field);

// Makes a rig of one camera alone of what a file says of only one, and notes that.
void UseOneCamera(absl::string_view what_says_so, const RigCamera& camera, ConvertedRig& converted);

// Returns the size that was asked for; INVALID_ARGUMENT says that the format leaves it out.
absl::StatusOr<PictureSize> NeedSize(const RigFiles& files);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_RIG_READERS_H_
