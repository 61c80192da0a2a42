#include "client_agent/live/ros2/ros2_settings.h"

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMostPairing_ms = 1000;
constexpr double kDepthPairing_ms = 20;
constexpr int kImuDepth = 1000;
constexpr int kMostPath = 100'000;

Rigid3d MotionOf(const std::vector<double>& numbers) {
  const Eigen::AngleAxisd roll(numbers[3], Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd pitch(numbers[4], Eigen::Vector3d::UnitY());
  const Eigen::AngleAxisd yaw(numbers[5], Eigen::Vector3d::UnitZ());
  return {(yaw * pitch * roll).normalized(), {numbers[0], numbers[1], numbers[2]}};
}

absl::StatusOr<Ros2Input> MakeInput(const Ros2Names& names, const std::string& name,
                                    absl::string_view transport, const Ros2Qos& qos,
                                    Ros2Parameters& parameters) {
  Ros2Input input{name, absl::StrCat(names.Resolve(name), transport), qos};
  RETURN_IF_ERROR(TakeQosOverrides(input.topic, "subscription", parameters, input.qos));
  return input;
}

absl::Status TakeCameras(const Ros2Names& names, Ros2Parameters& parameters,
                         Ros2Settings& settings) {
  std::string mode = "stereo";
  std::string transport = "raw";
  std::string depth_transport = "raw";
  RETURN_IF_ERROR(parameters.Take("tracking_mode", mode, {"stereo", "rgbd"}));
  RETURN_IF_ERROR(parameters.Take("image_transport", transport, {"raw", "compressed"}));
  RETURN_IF_ERROR(
      parameters.Take("depth_image_transport", depth_transport, {"raw", "compressedDepth"}));
  settings.is_rgbd = mode == "rgbd";
  settings.is_compressed = transport != "raw";
  settings.depth_is_compressed = depth_transport != "raw";
  if (settings.depth_is_compressed && !settings.is_rgbd) {
    return absl::InvalidArgumentError(
        "the parameter depth_image_transport is of tracking_mode rgbd");
  }
  if (settings.is_rgbd) settings.pair_within_ms = kDepthPairing_ms;
  Ros2Qos image_qos = kSensorData;
  RETURN_IF_ERROR(TakeQosProfile("image_qos", parameters, image_qos));
  // A best-effort reader hears reliable publishers, too.
  const Ros2Qos info_qos = kSensorData;
  const std::string picture_transport = settings.is_compressed ? "/compressed" : "";
  const std::string second_transport = !settings.is_rgbd              ? picture_transport
                                       : settings.depth_is_compressed ? "/compressedDepth"
                                                                      : "";
  const std::string second = settings.is_rgbd ? "visual_slam/depth_0" : "visual_slam/image_1";
  const std::string second_info =
      settings.is_rgbd ? "visual_slam/depth_camera_info_0" : "visual_slam/camera_info_1";
  ASSIGN_OR_RETURN(settings.images[0], MakeInput(names, "visual_slam/image_0", picture_transport,
                                                 image_qos, parameters));
  ASSIGN_OR_RETURN(settings.images[1],
                   MakeInput(names, second, second_transport, image_qos, parameters));
  ASSIGN_OR_RETURN(settings.infos[0],
                   MakeInput(names, "visual_slam/camera_info_0", "", info_qos, parameters));
  ASSIGN_OR_RETURN(settings.infos[1], MakeInput(names, second_info, "", info_qos, parameters));
  return parameters.Take("sync_matching_threshold_ms", settings.pair_within_ms, 0, kMostPairing_ms);
}

absl::Status TakeImu(const Ros2Names& names, Ros2Parameters& parameters, Ros2Settings& settings) {
  RETURN_IF_ERROR(parameters.Take("enable_imu_fusion", settings.uses_imu));
  RETURN_IF_ERROR(parameters.Take("imu_frame", settings.imu_frame));
  Ros2Qos qos = kSensorData;
  RETURN_IF_ERROR(TakeQosProfile("imu_qos", parameters, qos));
  qos.depth = kImuDepth;
  ASSIGN_OR_RETURN(settings.imu, MakeInput(names, "visual_slam/imu", "", qos, parameters));
  return absl::OkStatus();
}

absl::Status TakeFrames(Ros2Parameters& parameters, Ros2Settings& settings) {
  for (auto [name, frame] :
       {std::pair("map_frame", &settings.map_frame), std::pair("odom_frame", &settings.odom_frame),
        std::pair("base_frame", &settings.base_frame)}) {
    RETURN_IF_ERROR(parameters.Take(name, *frame));
    if (frame->empty()) {
      return absl::InvalidArgumentError(absl::StrCat("the parameter ", name, " is empty"));
    }
  }
  if (settings.map_frame == settings.odom_frame || settings.odom_frame == settings.base_frame ||
      settings.map_frame == settings.base_frame) {
    return absl::InvalidArgumentError(
        absl::StrCat("map_frame, odom_frame and base_frame must differ: '", settings.map_frame,
                     "', '", settings.odom_frame, "', '", settings.base_frame, "'"));
  }
  RETURN_IF_ERROR(parameters.Take("camera_optical_frame", settings.camera_frame));
  RETURN_IF_ERROR(parameters.Take("publish_map_to_odom_tf", settings.publish_map_to_odom_tf));
  RETURN_IF_ERROR(parameters.Take("publish_odom_to_base_tf", settings.publish_odom_to_base_tf));
  RETURN_IF_ERROR(parameters.Take("publish_base_to_camera_tf", settings.publish_base_to_camera_tf));
  // A level camera's z becomes x, its x becomes -y.
  std::vector<double> numbers = {0, 0, 0, -M_PI / 2, 0, -M_PI / 2};
  RETURN_IF_ERROR(parameters.Take("map_from_global", numbers, numbers.size()));
  settings.map_from_global = MotionOf(numbers);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Ros2Settings> ReadRos2Settings(const Ros2Names& names, Ros2Parameters& parameters) {
  Ros2Settings settings;
  RETURN_IF_ERROR(parameters.Take("use_sim_time", settings.use_sim_time));
  RETURN_IF_ERROR(TakeCameras(names, parameters, settings));
  RETURN_IF_ERROR(TakeImu(names, parameters, settings));
  RETURN_IF_ERROR(TakeFrames(parameters, settings));
  RETURN_IF_ERROR(parameters.Take("path_max_size", settings.path_max_size, 1, kMostPath));
  RETURN_IF_ERROR(parameters.Take("near_map_radius_m", settings.near_map_radius_m, 1, 1000));
  RETURN_IF_ERROR(parameters.Take("watchdog_s", settings.silent_after_s, 0.5, 3600));
  RETURN_IF_ERROR(TakeQosOverrides(names.Resolve("visual_slam/tracking/odometry"), "publisher",
                                   parameters, settings.odometry_qos));
  RETURN_IF_ERROR(parameters.CheckAllTaken());
  return settings;
}

}  // namespace corbslam::client_agent
