// The calibrations of recordings that are known: EuRoC and KITTI.
#include <filesystem>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/calibration/euroc_calibration.h"
#include "client_agent/source/calibration/kitti_calibration.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

RigCamera CameraOf(const EurocCamera& camera) {
  return {camera.intrinsics, camera.width_px, camera.height_px};
}

struct KittiRows {
  const char* left;
  const char* right;
  std::optional<PictureSize> size;  // Of the rectified pictures, where the file says it.
};

// Returns the rows of KITTI raw where its size is there, else those of KITTI odometry.
absl::StatusOr<KittiRows> FindRows(const std::string& path) {
  KittiRows rows = {"P0", "P1", std::nullopt};
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const std::vector<absl::string_view> fields =
        absl::StrSplit(text, absl::ByAnyChar(": \t"), absl::SkipEmpty());
    if (fields.size() != 3 || fields[0] != "S_rect_00") return absl::OkStatus();
    ASSIGN_OR_RETURN(const std::vector<double> size,
                     ParseNumbers({fields[1], fields[2]}, path, line));
    ASSIGN_OR_RETURN(const PictureSize whole, ToSize(size[0], size[1], path, "S_rect_00"));
    rows = {"P_rect_00", "P_rect_01", whole};
    return absl::OkStatus();
  }));
  return rows;
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadEurocPair(const RigFiles& files) {
  std::vector<std::string> paths = files.paths;
  std::error_code ignored;
  if (paths.size() == 1 && std::filesystem::is_directory(paths[0], ignored)) {
    const std::string root = EurocRoot(paths[0]);
    paths = {root + "/cam0/sensor.yaml", root + "/cam1/sensor.yaml"};
    const std::string imu = root + "/imu0/sensor.yaml";
    if (std::filesystem::exists(imu, ignored)) paths.push_back(imu);
  }
  if (paths.size() != 2 && paths.size() != 3) {
    return ExpectFiles(files, 2,
                       "cam0/sensor.yaml and cam1/sensor.yaml (and imu0/sensor.yaml), or their "
                       "folder");
  }
  ASSIGN_OR_RETURN(const EurocCamera left, ReadEurocCamera(paths[0]));
  ASSIGN_OR_RETURN(const EurocCamera right, ReadEurocCamera(paths[1]));
  ConvertedRig converted;
  converted.rig.cameras = {CameraOf(left), CameraOf(right)};
  converted.rig.right_from_left = right.body_from_camera.Inverse() * left.body_from_camera;
  converted.rig.body_from_camera = left.body_from_camera;
  converted.rig.close_depth_m =
      kEurocCloseDepth_baselines * converted.rig.right_from_left.translation.norm();
  if (paths.size() < 3) return converted;
  ASSIGN_OR_RETURN(EurocImu imu, ReadEurocImu(paths[2]));
  imu.stated.imu_from_camera = imu.body_from_imu.Inverse() * left.body_from_camera;
  converted.rig.imu = imu.stated;
  return converted;
}

absl::StatusOr<ConvertedRig> ReadKittiPair(const RigFiles& files) {
  RETURN_IF_ERROR(ExpectFiles(files, 1, "calib.txt or calib_cam_to_cam.txt"));
  const std::string& path = files.paths[0];
  ASSIGN_OR_RETURN(KittiRows rows, FindRows(path));
  if (!rows.size.has_value()) {
    ASSIGN_OR_RETURN(rows.size, NeedSize(files));
  }
  ASSIGN_OR_RETURN(const FoundKittiCalibration found,
                   ReadKittiCalibration({path, rows.left, rows.right, rows.size->width_px,
                                         rows.size->height_px, files.trust}));
  const Camera& camera = found.calibration.camera;
  RigCamera left = {{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, {}},
                    camera.width_px,
                    camera.height_px};
  RigCamera right = left;
  right.raw.cx_px += found.calibration.right_cx_offset_px;
  ConvertedRig converted;
  converted.rig.cameras = {left, right};
  converted.rig.rectified = true;
  converted.rig.baseline_m = camera.baseline_m;
  converted.rig.close_depth_m = camera.close_depth_m;
  return converted;
}

}  // namespace corbslam::client_agent
