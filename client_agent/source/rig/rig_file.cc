#include "client_agent/source/rig/rig_file.h"

#include <filesystem>
#include <set>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/calibration/yaml_numbers.h"
#include "client_agent/source/rig/rig_part.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMostNoDepths = 16;

// Reads what every camera has, time_offset_s aside.
absl::StatusOr<RigCamera> ReadCamera(const Part& part, const std::set<std::string>& more = {}) {
  std::set<std::string> known = {"size_px", "focal_px", "principal_px", "lens", "lens_numbers"};
  known.insert(more.begin(), more.end());
  RETURN_IF_ERROR(part.CheckFields(known));
  RigCamera camera;
  if (!part.Has("size_px")) return part.Bad(absl::StrCat(part.Named("size_px"), " is missing"));
  ASSIGN_OR_RETURN(const PictureSize size,
                   ReadSize(part["size_px"], part.path(), part.Named("size_px")));
  ASSIGN_OR_RETURN(const auto focal, part.Numbers("focal_px", 2, 2));
  ASSIGN_OR_RETURN(const auto principal, part.Numbers("principal_px", 2, 2));
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  camera.raw = {focal[0], focal[1], principal[0], principal[1], {}};
  if (!part.Has("lens")) {
    if (!part.Has("lens_numbers")) return camera;
    return part.Bad(
        absl::StrCat(part.Named("lens"), " is missing, which says what lens_numbers are"));
  }
  ASSIGN_OR_RETURN(const std::string word, part.Word("lens"));
  std::vector<double> numbers;
  if (part.Has("lens_numbers")) {
    ASSIGN_OR_RETURN(numbers, part.Numbers("lens_numbers", 0, 14));
  }
  if (numbers.empty() && word != "none") {
    return part.Bad(absl::StrCat(part.Named("lens_numbers"), " is missing, which a lens that is '",
                                 word,
                                 "' has: give them, or leave lens out for a pinhole that "
                                 "does not distort"));
  }
  const auto lens = LensOfName(word, numbers);
  if (!lens.ok()) return part.Bad(absl::StrCat(part.Named("lens"), ": ", lens.status().message()));
  camera.raw.lens = *lens;
  return camera;
}

absl::Status ReadCameras(const Part& top, Rig& rig) {
  const YAML::Node list = top["cameras"];
  if (!list.IsDefined() || !list.IsSequence() || list.size() == 0) {
    return top.Bad("cameras is missing: a list of a left and a right one, or of one");
  }
  for (size_t i = 0; i < list.size(); ++i) {
    const Part part(top.path(), absl::StrCat("cameras[", i, "]."), list[i]);
    ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(part, {"time_offset_s"}));
    RETURN_IF_ERROR(part.Set("time_offset_s", rig.cameras.back().time_offset_s));
  }
  return absl::OkStatus();
}

absl::Status ReadStereoFields(const Part& top, Rig& rig) {
  RETURN_IF_ERROR(top.Set("rectified", rig.rectified));
  RETURN_IF_ERROR(top.Set("baseline_m", rig.baseline_m));
  RETURN_IF_ERROR(top.Set("widest_field_deg", rig.widest_field_deg));
  if (rig.rectified != top.Has("baseline_m")) {
    return top.Bad(rig.rectified ? "baseline_m is missing, which rectified pairs have"
                                 : "baseline_m is of rectified pairs; others have right_from_left");
  }
  if (rig.rectified == top.Has("right_from_left")) {
    return top.Bad(rig.rectified ? "right_from_left is of pairs that are not rectified"
                                 : "right_from_left is missing");
  }
  if (rig.rectified) return absl::OkStatus();
  ASSIGN_OR_RETURN(rig.right_from_left, top.Motion("right_from_left"));
  return absl::OkStatus();
}

// Reads the camera that measures depth, where it isn't the other one.
absl::Status ReadDepthCamera(const Part& part, RigDepth& depth) {
  if (part.Has("camera") != part.Has("colour_from_depth")) {
    return part.Bad(part.Has("camera")
                        ? "depth.colour_from_depth is missing: where depth.camera sits beside the "
                          "other one, 4x4 by rows, metres"
                        : "depth.camera is missing, which colour_from_depth is of");
  }
  if (!part.Has("camera")) return absl::OkStatus();
  ASSIGN_OR_RETURN(depth.camera, ReadCamera(Part(part.path(), "depth.camera.", part["camera"])));
  ASSIGN_OR_RETURN(depth.colour_from_depth, part.Motion("colour_from_depth"));
  return absl::OkStatus();
}

absl::Status ReadDepth(const Part& top, Rig& rig) {
  if (!top.Has("depth")) return top.Bad("depth is missing, which RGB-D cameras have");
  const Part part(top.path(), "depth.", top["depth"]);
  RETURN_IF_ERROR(part.CheckFields({"units_per_m", "virtual_baseline_m", "no_depth", "camera",
                                    "colour_from_depth", "time_offset_s"}));
  RETURN_IF_ERROR(part.Set("units_per_m", rig.depth.units_per_m));
  RETURN_IF_ERROR(part.Set("virtual_baseline_m", rig.depth.virtual_baseline_m));
  RETURN_IF_ERROR(part.Set("time_offset_s", rig.depth.time_offset_s));
  if (part.Has("no_depth")) {
    ASSIGN_OR_RETURN(rig.depth.no_depth, part.Numbers("no_depth", 0, kMostNoDepths));
  }
  return ReadDepthCamera(part, rig.depth);
}

absl::Status ReadImu(const Part& top, Rig& rig) {
  if (!top.Has("imu")) return absl::OkStatus();
  const Part part(top.path(), "imu.", top["imu"]);
  RETURN_IF_ERROR(part.CheckFields({"imu_from_camera", "rate_hz", "gyro_noise", "accel_noise",
                                    "gyro_walk", "accel_walk", "time_offset_s"}));
  StatedImu& imu = rig.imu.emplace();
  ASSIGN_OR_RETURN(imu.imu_from_camera, part.Motion("imu_from_camera"));
  RETURN_IF_ERROR(part.Set("rate_hz", imu.rate_hz));
  RETURN_IF_ERROR(part.Set("gyro_noise", imu.gyro_noise));
  RETURN_IF_ERROR(part.Set("accel_noise", imu.accel_noise));
  RETURN_IF_ERROR(part.Set("gyro_walk", imu.gyro_walk));
  RETURN_IF_ERROR(part.Set("accel_walk", imu.accel_walk));
  return part.Set("time_offset_s", imu.time_offset_s);
}

absl::Status ReadKind(const Part& top, Rig& rig) {
  ASSIGN_OR_RETURN(const std::string kind, top.Word("kind"));
  std::set<std::string> known = {"rig",           "kind",    "cameras", "body_from_camera",
                                 "close_depth_m", "rate_hz", "mask",    "imu"};
  if (kind == "stereo") {
    known.insert({"rectified", "baseline_m", "right_from_left", "widest_field_deg"});
  } else if (kind == "rgbd") {
    rig.kind = RigKind::kRgbd;
    known.insert("depth");
  } else if (kind == "monocular") {
    rig.kind = RigKind::kMonocular;
    known.erase("close_depth_m");
  } else {
    return top.Bad(absl::StrCat("kind is '", kind, "', must be stereo, rgbd or monocular"));
  }
  return top.CheckFields(known);
}

absl::Status ReadKindFields(const Part& top, Rig& rig) {
  switch (rig.kind) {
    case RigKind::kStereo:
      return ReadStereoFields(top, rig);
    case RigKind::kRgbd:
      return ReadDepth(top, rig);
    case RigKind::kMonocular:
      break;
  }
  return absl::OkStatus();
}

absl::Status ReadFormat(const Part& top) {
  double format = 0;
  RETURN_IF_ERROR(top.Set("rig", format));
  if (format == kRigFormat) return absl::OkStatus();
  return top.Bad(absl::StrCat("rig is ", format, ": 'rig: ", kRigFormat,
                              "' says that this is a rig file, in the format that is read here"));
}

absl::Status ReadMaskPath(const Part& top, Rig& rig) {
  if (!top.Has("mask")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string mask, top.Word("mask"));
  // An absolute path stays as it is.
  rig.mask_file = (std::filesystem::path(top.path()).parent_path() / mask).string();
  return absl::OkStatus();
}

absl::Status ReadAll(const Part& top, Rig& rig) {
  RETURN_IF_ERROR(ReadFormat(top));
  RETURN_IF_ERROR(ReadKind(top, rig));
  RETURN_IF_ERROR(ReadCameras(top, rig));
  RETURN_IF_ERROR(ReadKindFields(top, rig));
  if (top.Has("body_from_camera")) {
    ASSIGN_OR_RETURN(rig.body_from_camera, top.Motion("body_from_camera"));
  }
  RETURN_IF_ERROR(top.Set("close_depth_m", rig.close_depth_m));
  RETURN_IF_ERROR(top.Set("rate_hz", rig.rate_hz));
  RETURN_IF_ERROR(ReadMaskPath(top, rig));
  RETURN_IF_ERROR(ReadImu(top, rig));
  const absl::Status possible = Validate(rig);
  return possible.ok() ? possible : top.Bad(possible.message());
}

}  // namespace

absl::StatusOr<Rig> ReadRigFile(const std::string& path) {
  Rig rig;
  RETURN_IF_ERROR(UseYamlFields(
      path, [&](const YAML::Node& file) { return ReadAll(Part(path, "", file), rig); }));
  return rig;
}

absl::StatusOr<Rig> ReadRigText(const std::string& text, const std::string& name) {
  Rig rig;
  RETURN_IF_ERROR(UseYamlText(name, text, [&](const YAML::Node& file) {
    const Part top(name, "", file);
    if (top.Has("mask")) return top.Bad("mask names a file, which only a rig file may do");
    return ReadAll(top, rig);
  }));
  return rig;
}

}  // namespace corbslam::client_agent
