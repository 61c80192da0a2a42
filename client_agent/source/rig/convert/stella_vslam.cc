// stella_vslam's configuration: Camera with setup, model and the numbers; StereoRectifier of pairs
// that it rectifies itself.
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "client_agent/source/rig/rectified_motion.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::Status Bad(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", what));
}

std::string WordOf(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
}

absl::StatusOr<double> NumberOf(const YAML::Node& camera, const char* name,
                                const std::string& path) {
  if (!camera[name].IsDefined()) return Bad(path, absl::StrCat("Camera.", name, " is missing"));
  return ReadNumber(camera[name], path, absl::StrCat("Camera.", name));
}

absl::StatusOr<LensModel> ReadLens(const YAML::Node& camera, const std::string& model,
                                   const std::string& path) {
  const bool is_fisheye = model == "fisheye";
  if (!is_fisheye && model != "perspective") {
    return Bad(path, absl::StrCat("Camera.model is '", model,
                                  "', known are perspective and fisheye: calibrate with one of "
                                  "these"));
  }
  std::vector<double> numbers;
  const std::vector<const char*> names =
      is_fisheye ? std::vector<const char*>{"k1", "k2", "k3", "k4"}
                 : std::vector<const char*>{"k1", "k2", "p1", "p2", "k3"};
  for (const char* name : names) {
    if (!camera[name].IsDefined()) {
      numbers.push_back(0);
      continue;
    }
    ASSIGN_OR_RETURN(numbers.emplace_back(), NumberOf(camera, name, path));
  }
  return LensOfName(is_fisheye ? "equidistant" : "radial-tangential", numbers);
}

absl::StatusOr<RigCamera> ReadCamera(const YAML::Node& camera, const std::string& path) {
  RigCamera read;
  ASSIGN_OR_RETURN(read.raw.fx_px, NumberOf(camera, "fx", path));
  ASSIGN_OR_RETURN(read.raw.fy_px, NumberOf(camera, "fy", path));
  ASSIGN_OR_RETURN(read.raw.cx_px, NumberOf(camera, "cx", path));
  ASSIGN_OR_RETURN(read.raw.cy_px, NumberOf(camera, "cy", path));
  ASSIGN_OR_RETURN(read.raw.lens, ReadLens(camera, WordOf(camera["model"]), path));
  ASSIGN_OR_RETURN(const double cols, NumberOf(camera, "cols", path));
  ASSIGN_OR_RETURN(const double rows, NumberOf(camera, "rows", path));
  ASSIGN_OR_RETURN(const PictureSize size, ToSize(cols, rows, path, "Camera.cols, Camera.rows"));
  read.width_px = size.width_px;
  read.height_px = size.height_px;
  return read;
}

// Reads one camera of a pair that stella_vslam rectifies, and its rotation rectified_from_camera.
absl::StatusOr<std::pair<RigCamera, Eigen::Matrix3d>> ReadRaw(const YAML::Node& rectifier,
                                                              const RigCamera& rectified,
                                                              const std::string& side,
                                                              const std::string& path) {
  const std::string field = "StereoRectifier.";
  ASSIGN_OR_RETURN(const auto k,
                   ReadNumbers(rectifier["K_" + side], path, field + "K_" + side, 9, 9));
  ASSIGN_OR_RETURN(const auto d,
                   ReadNumbers(rectifier["D_" + side], path, field + "D_" + side, 4, 5));
  ASSIGN_OR_RETURN(const auto r,
                   ReadNumbers(rectifier["R_" + side], path, field + "R_" + side, 9, 9));
  RETURN_IF_ERROR(CheckCameraMatrix(k, path, field + "K_" + side));
  RigCamera camera = rectified;
  camera.raw = {k[0], k[4], k[2], k[5], {}};
  const bool is_fisheye = WordOf(rectifier["model"]) == "fisheye";
  ASSIGN_OR_RETURN(camera.raw.lens,
                   LensOfName(is_fisheye ? "equidistant" : "radial-tangential", d));
  Eigen::Matrix3d rotation;
  rotation << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  return std::pair(camera, rotation);
}

absl::Status ReadPair(const YAML::Node& file, const RigCamera& camera, const std::string& path,
                      Rig& rig) {
  ASSIGN_OR_RETURN(const double bf_px_m, NumberOf(file["Camera"], "focal_x_baseline", path));
  const double baseline_m = bf_px_m / camera.raw.fx_px;
  const YAML::Node rectifier = file["StereoRectifier"];
  if (!rectifier.IsDefined()) {
    rig.cameras = {camera, camera};
    rig.rectified = true;
    rig.baseline_m = baseline_m;
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const auto left, ReadRaw(rectifier, camera, "left", path));
  ASSIGN_OR_RETURN(const auto right, ReadRaw(rectifier, camera, "right", path));
  rig.cameras = {left.first, right.first};
  rig.right_from_left = MotionOfRectified(left.second, right.second, baseline_m);
  return absl::OkStatus();
}

absl::Status ReadDepthUnits(const YAML::Node& file, const std::string& path, Rig& rig) {
  for (const char* part : {"Preprocessing", "Camera"}) {
    const YAML::Node units = file[part].IsMap() ? file[part]["depthmap_factor"] : YAML::Node();
    if (!units.IsDefined() || units.IsNull()) continue;
    ASSIGN_OR_RETURN(rig.depth.units_per_m,
                     ReadNumber(units, path, absl::StrCat(part, ".depthmap_factor")));
    return absl::OkStatus();
  }
  return Bad(path, "depthmap_factor is missing: how many units of depth a metre has");
}

absl::Status Read(const YAML::Node& file, const std::string& path, ConvertedRig& converted) {
  const YAML::Node node = file["Camera"];
  if (!node.IsMap()) return Bad(path, "Camera holds no fields");
  ASSIGN_OR_RETURN(const RigCamera camera, ReadCamera(node, path));
  Rig& rig = converted.rig;
  if (node["fps"].IsDefined()) {
    ASSIGN_OR_RETURN(rig.rate_hz, NumberOf(node, "fps", path));
  }
  const std::string setup = WordOf(node["setup"]);
  if (setup == "stereo") return ReadPair(file, camera, path, rig);
  if (setup == "RGBD") {
    rig.kind = RigKind::kRgbd;
    rig.cameras = {camera};
    return ReadDepthUnits(file, path, rig);
  }
  if (setup == "monocular") {
    UseOneCamera("Camera.setup is 'monocular'", camera, converted);
    return absl::OkStatus();
  }
  return Bad(path,
             absl::StrCat("Camera.setup is '", setup, "', must be stereo, RGBD or monocular"));
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadStellaVslam(const RigFiles& files) {
  return ReadOneFile(files, "stella_vslam's configuration", &Read);
}

}  // namespace corbslam::client_agent
