#include "services/tool/sequence/layout_files.h"

#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::SourceLayout;

namespace {

constexpr char kEurocTruth[] = "mav0/state_groundtruth_estimate0";

// Writes as many digits as bring the same number back.
std::string Exact(double number) { return absl::StrFormat("%.17g", number); }

std::string ProjectionLine(const char* name, const Camera& camera, double baseline_m) {
  return absl::StrCat(name, ": ", Exact(camera.fx_px), " 0 ", Exact(camera.cx_px), " ",
                      Exact(-camera.fx_px * baseline_m), " 0 ", Exact(camera.fy_px), " ",
                      Exact(camera.cy_px), " 0 0 0 1 0");
}

absl::Status WriteKittiFiles(const std::string& folder, const Camera& camera,
                             const Trajectory& truth) {
  RETURN_IF_ERROR(
      WriteLines({ProjectionLine("P0", camera, 0), ProjectionLine("P1", camera, camera.baseline_m)},
                 folder + "/calib.txt"));
  std::vector<std::string> times;
  for (const StampedPose& pose : truth) times.push_back(FormatSeconds(pose.timestamp_ns));
  RETURN_IF_ERROR(WriteLines(times, folder + "/times.txt"));
  return WriteKittiTrajectory(truth, folder + "/poses.txt");
}

absl::Status WriteEurocCamera(const std::string& folder, int index, const Camera& camera,
                              const Trajectory& truth) {
  const std::string root = absl::StrCat(folder, "/mav0/cam", index);
  const double aside_m = index == 0 ? 0 : camera.baseline_m;
  const std::vector<std::string> yaml = {
      "%YAML:1.0",
      "sensor_type: camera",
      absl::StrCat("comment: simulated cam", index),
      "T_BS:",
      "  cols: 4",
      "  rows: 4",
      absl::StrCat("  data: [1.0, 0.0, 0.0, ", Exact(aside_m),
                   ", 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]"),
      absl::StrCat("resolution: [", camera.width_px, ", ", camera.height_px, "]"),
      "camera_model: pinhole",
      absl::StrCat("intrinsics: [", Exact(camera.fx_px), ", ", Exact(camera.fy_px), ", ",
                   Exact(camera.cx_px), ", ", Exact(camera.cy_px), "]"),
      "distortion_model: radial-tangential",
      "distortion_coefficients: [0.0, 0.0, 0.0, 0.0]"};
  RETURN_IF_ERROR(WriteLines(yaml, root + "/sensor.yaml"));
  std::vector<std::string> list = {"#timestamp [ns],filename"};
  for (const StampedPose& pose : truth) {
    list.push_back(absl::StrCat(pose.timestamp_ns, ",", pose.timestamp_ns, ".png"));
  }
  return WriteLines(list, root + "/data.csv");
}

absl::Status WriteEurocFiles(const std::string& folder, const Camera& camera,
                             const Trajectory& truth) {
  RETURN_IF_ERROR(WriteEurocCamera(folder, 0, camera, truth));
  RETURN_IF_ERROR(WriteEurocCamera(folder, 1, camera, truth));
  std::vector<std::string> lines = {
      "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []"};
  for (const StampedPose& pose : truth) {
    const Eigen::Vector3d& t = pose.world_from_camera.translation;
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    lines.push_back(absl::StrFormat("%d,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f", pose.timestamp_ns,
                                    t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()));
  }
  return WriteLines(lines, absl::StrCat(folder, "/", kEurocTruth, "/data.csv"));
}

absl::Status WriteTumFiles(const std::string& folder, const RgbdCalibration& calibration,
                           const Trajectory& truth) {
  const Camera& camera = calibration.camera;
  RETURN_IF_ERROR(WriteLines(
      {absl::StrCat("fx: ", Exact(camera.fx_px)), absl::StrCat("fy: ", Exact(camera.fy_px)),
       absl::StrCat("cx: ", Exact(camera.cx_px)), absl::StrCat("cy: ", Exact(camera.cy_px)),
       absl::StrCat("depth_units_per_m: ", Exact(calibration.depth_units_per_m))},
      folder + "/calibration.yaml"));
  std::vector<std::string> both;
  std::vector<std::string> grey;
  std::vector<std::string> depth;
  for (size_t i = 0; i < truth.size(); ++i) {
    const std::string time = FormatSeconds(truth[i].timestamp_ns);
    const FramePaths paths = PathsOfFrame(SourceLayout::kTum, i, truth[i].timestamp_ns);
    grey.push_back(absl::StrCat(time, " ", paths.first));
    depth.push_back(absl::StrCat(time, " ", paths.second));
    both.push_back(absl::StrCat(grey.back(), " ", depth.back()));
  }
  RETURN_IF_ERROR(WriteLines(both, folder + "/associated.txt"));
  RETURN_IF_ERROR(WriteLines(grey, folder + "/rgb.txt"));
  RETURN_IF_ERROR(WriteLines(depth, folder + "/depth.txt"));
  return WriteTumTrajectory(truth, folder + "/groundtruth.txt");
}

std::vector<std::string> FoldersOf(SourceLayout layout) {
  switch (layout) {
    case SourceLayout::kKitti:
      return {"image_0", "image_1"};
    case SourceLayout::kEuroc:
      return {"mav0/cam0/data", "mav0/cam1/data", kEurocTruth};
    case SourceLayout::kTum:
      return {"rgb", "depth"};
    case SourceLayout::kSevenScenes:
    case SourceLayout::kRegistered:
      break;
  }
  return {};
}

}  // namespace

FramePaths PathsOfFrame(SourceLayout layout, size_t index, int64_t timestamp_ns) {
  switch (layout) {
    case SourceLayout::kKitti:
      return {absl::StrFormat("image_0/%06d.png", index),
              absl::StrFormat("image_1/%06d.png", index)};
    case SourceLayout::kEuroc:
      return {absl::StrCat("mav0/cam0/data/", timestamp_ns, ".png"),
              absl::StrCat("mav0/cam1/data/", timestamp_ns, ".png")};
    case SourceLayout::kTum: {
      const std::string time = FormatSeconds(timestamp_ns);
      return {absl::StrCat("rgb/", time, ".png"), absl::StrCat("depth/", time, ".png")};
    }
    case SourceLayout::kSevenScenes:
    case SourceLayout::kRegistered:
      break;
  }
  return {};
}

absl::Status MakeLayoutFolders(SourceLayout layout, const std::string& folder) {
  for (const std::string& each : FoldersOf(layout)) {
    RETURN_IF_ERROR(MakeFolder(absl::StrCat(folder, "/", each)));
  }
  return absl::OkStatus();
}

absl::Status WriteLayoutFiles(SourceLayout layout, const std::string& folder,
                              const SensorCalibration& calibration, const Trajectory& truth) {
  const auto* stereo = std::get_if<StereoCalibration>(&calibration);
  const auto* rgbd = std::get_if<RgbdCalibration>(&calibration);
  if (layout == SourceLayout::kKitti && stereo != nullptr) {
    return WriteKittiFiles(folder, stereo->camera, truth);
  }
  if (layout == SourceLayout::kEuroc && stereo != nullptr) {
    return WriteEurocFiles(folder, stereo->camera, truth);
  }
  if (layout == SourceLayout::kTum && rgbd != nullptr) return WriteTumFiles(folder, *rgbd, truth);
  return absl::InvalidArgumentError(
      "kitti and euroc take rectified stereo (rig=kitti, rig=euroc), tum takes RGB-D (rig=rgbd)");
}

}  // namespace corbslam::services
