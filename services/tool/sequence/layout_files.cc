#include "services/tool/sequence/layout_files.h"

#include <array>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/lists/imu_list.h"
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

absl::Status WriteKittiFiles(const std::string& folder, const StereoCalibration& stereo,
                             const Trajectory& truth) {
  const Camera& camera = stereo.camera;
  if (!stereo.raw.has_value()) {
    RETURN_IF_ERROR(WriteLines(
        {ProjectionLine("P0", camera, 0), ProjectionLine("P1", camera, camera.baseline_m)},
        folder + "/calib.txt"));
  }
  std::vector<std::string> times;
  for (const StampedPose& pose : truth) times.push_back(FormatSeconds(pose.timestamp_ns));
  RETURN_IF_ERROR(WriteLines(times, folder + "/times.txt"));
  return WriteKittiTrajectory(truth, folder + "/poses.txt");
}

// A camera of a pair, as EuRoC's sensor.yaml says it; the left camera's frame is the body's.
struct EurocFile {
  RawCamera raw;
  int width_px = 0;
  int height_px = 0;
  Rigid3d left_from_camera;
};

// Returns EuRoC's word for the distortion and its numbers.
absl::StatusOr<std::pair<std::string, std::vector<double>>> EurocLens(const LensModel& lens) {
  if (const auto* pinhole = std::get_if<RadialTangential>(&lens)) {
    if (pinhole->k3 == 0 && !pinhole->IsRational()) {
      return std::pair("radial-tangential",
                       std::vector<double>{pinhole->k1, pinhole->k2, pinhole->p1, pinhole->p2});
    }
  } else if (const auto* fisheye = std::get_if<Equidistant>(&lens)) {
    return std::pair("equidistant",
                     std::vector<double>{fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4});
  }
  return absl::InvalidArgumentError(absl::StrCat("euroc's sensor.yaml has no word for ",
                                                 DescribeLens(lens),
                                                 ": write the layout kitti, whose rig.yaml has"));
}

std::string Listed(const std::vector<double>& numbers) {
  return absl::StrCat(
      "[",
      absl::StrJoin(numbers, ", ",
                    [](std::string* out, double number) { absl::StrAppend(out, Exact(number)); }),
      "]");
}

std::string Matrix(const Rigid3d& motion) {
  const Eigen::Matrix3d r = motion.rotation.toRotationMatrix();
  std::vector<double> rows;
  for (int i = 0; i < 3; ++i) {
    rows.insert(rows.end(), {r(i, 0), r(i, 1), r(i, 2), motion.translation(i)});
  }
  rows.insert(rows.end(), {0, 0, 0, 1});
  return Listed(rows);
}

absl::Status WriteEurocCamera(const std::string& folder, int index, const EurocFile& camera,
                              const Trajectory& truth) {
  const std::string root = absl::StrCat(folder, "/mav0/cam", index);
  ASSIGN_OR_RETURN(const auto lens, EurocLens(camera.raw.lens));
  const std::vector<std::string> yaml = {
      "%YAML:1.0",
      "sensor_type: camera",
      absl::StrCat("comment: simulated cam", index),
      "T_BS:",
      "  cols: 4",
      "  rows: 4",
      "  data: " + Matrix(camera.left_from_camera),
      absl::StrCat("resolution: [", camera.width_px, ", ", camera.height_px, "]"),
      "camera_model: pinhole",
      "intrinsics: " +
          Listed({camera.raw.fx_px, camera.raw.fy_px, camera.raw.cx_px, camera.raw.cy_px}),
      "distortion_model: " + lens.first,
      "distortion_coefficients: " + Listed(lens.second)};
  RETURN_IF_ERROR(WriteLines(yaml, root + "/sensor.yaml"));
  std::vector<std::string> list = {"#timestamp [ns],filename"};
  for (const StampedPose& pose : truth) {
    list.push_back(absl::StrCat(pose.timestamp_ns, ",", pose.timestamp_ns, ".png"));
  }
  return WriteLines(list, root + "/data.csv");
}

std::array<EurocFile, 2> EurocPair(const StereoCalibration& stereo) {
  if (!stereo.raw.has_value()) {
    const Camera& camera = stereo.camera;
    const RawCamera raw = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, {}};
    const Rigid3d aside = {Eigen::Quaterniond::Identity(), {camera.baseline_m, 0, 0}};
    return {EurocFile{raw, camera.width_px, camera.height_px, {}},
            EurocFile{raw, camera.width_px, camera.height_px, aside}};
  }
  const RawStereo& raw = *stereo.raw;
  return {EurocFile{raw.left, raw.width_px, raw.height_px, {}},
          EurocFile{raw.right, raw.width_px, raw.height_px, raw.right_from_left.Inverse()}};
}

absl::Status WriteEurocFiles(const std::string& folder, const StereoCalibration& stereo,
                             const Trajectory& truth) {
  const std::array<EurocFile, 2> pair = EurocPair(stereo);
  RETURN_IF_ERROR(WriteEurocCamera(folder, 0, pair[0], truth));
  RETURN_IF_ERROR(WriteEurocCamera(folder, 1, pair[1], truth));
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

absl::Status WriteEurocImu(const std::string& folder, const ImuCalibration& imu,
                           const ImuSamples& samples) {
  const std::string root = folder + "/mav0/imu0";
  RETURN_IF_ERROR(MakeFolder(root));
  const std::vector<std::string> yaml = {
      "%YAML:1.0",
      "sensor_type: imu",
      "comment: simulated imu0",
      "T_BS:",
      "  cols: 4",
      "  rows: 4",
      "  data: " + Matrix(imu.imu_from_camera.Inverse()),
      "rate_hz: " + Exact(imu.rate_hz),
      "gyroscope_noise_density: " + Exact(imu.noise.gyro),
      "gyroscope_random_walk: " + Exact(imu.noise.gyro_walk),
      "accelerometer_noise_density: " + Exact(imu.noise.accel),
      "accelerometer_random_walk: " + Exact(imu.noise.accel_walk)};
  RETURN_IF_ERROR(WriteLines(yaml, root + "/sensor.yaml"));
  std::vector<std::string> list = {client_agent::kImuHeading};
  for (const ImuSample& sample : samples) list.push_back(client_agent::FormatImuLine(sample));
  return WriteLines(list, root + "/data.csv");
}

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
    return WriteKittiFiles(folder, *stereo, truth);
  }
  if (layout == SourceLayout::kEuroc && stereo != nullptr) {
    return WriteEurocFiles(folder, *stereo, truth);
  }
  if (layout == SourceLayout::kTum && rgbd != nullptr) return WriteTumFiles(folder, *rgbd, truth);
  return absl::InvalidArgumentError(
      "kitti and euroc take stereo (rig=kitti, rig=euroc, rig=FILE), tum takes RGB-D (rig=rgbd)");
}

}  // namespace corbslam::services
