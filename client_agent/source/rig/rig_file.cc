#include "client_agent/source/rig/rig_file.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/calibration/lens_words.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/calibration/yaml_numbers.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr int kFormat = 1;

// The fields of a part of the file, which is a map: each is known and read once.
class Part {
 public:
  Part(std::string path, std::string name, const YAML::Node& node)
      : path_(std::move(path)), name_(std::move(name)), node_(node) {}

  absl::Status CheckFields(const std::set<std::string>& known) const {
    if (!node_.IsMap()) return Bad("holds no fields");
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (!known.contains(key)) {
        return LineError(
            path_, LineOf(entry.first),
            absl::StrCat("unknown field ", key, ": known are ", absl::StrJoin(known, ", ")));
      }
      if (!seen.insert(key).second) {
        return LineError(path_, LineOf(entry.first), absl::StrCat(key, " is there twice"));
      }
    }
    return absl::OkStatus();
  }
  bool Has(const char* field) const { return node_[field].IsDefined(); }
  YAML::Node operator[](const char* field) const { return node_[field]; }
  std::string Named(const char* field) const { return absl::StrCat(name_, field); }
  const std::string& path() const { return path_; }

  absl::StatusOr<std::vector<double>> Numbers(const char* field, size_t least, size_t most) const {
    if (!Has(field)) return Bad(absl::StrCat(Named(field), " is missing"));
    return ReadNumbers(node_[field], path_, Named(field), least, most);
  }
  absl::Status Set(const char* field, double& number) const {
    if (!Has(field)) return absl::OkStatus();
    ASSIGN_OR_RETURN(number, ReadNumber(node_[field], path_, Named(field)));
    return absl::OkStatus();
  }
  absl::Status Set(const char* field, std::optional<double>& number) const {
    return Has(field) ? Set(field, number.emplace()) : absl::OkStatus();
  }
  absl::Status Set(const char* field, bool& flag) const {
    if (!Has(field)) return absl::OkStatus();
    const std::string word = node_[field].IsScalar() ? node_[field].Scalar() : "";
    if (word != "true" && word != "false") {
      return Bad(absl::StrCat(Named(field), " is '", word, "', must be true or false"));
    }
    flag = word == "true";
    return absl::OkStatus();
  }
  absl::StatusOr<std::string> Word(const char* field) const {
    if (Has(field) && node_[field].IsScalar()) return node_[field].Scalar();
    return Bad(absl::StrCat(Named(field), " is missing"));
  }
  absl::StatusOr<Rigid3d> Motion(const char* field) const {
    ASSIGN_OR_RETURN(const std::vector<double> rows, Numbers(field, 16, 16));
    return ToRigid(rows, path_, Named(field));
  }
  absl::Status Bad(absl::string_view what) const {
    return absl::InvalidArgumentError(absl::StrCat(path_, ": ", what));
  }

 private:
  std::string path_;
  std::string name_;  // Written before its fields' names: "cameras[0].".
  YAML::Node node_;
};

absl::StatusOr<RigCamera> ReadCamera(const Part& part) {
  RETURN_IF_ERROR(
      part.CheckFields({"size_px", "focal_px", "principal_px", "lens", "lens_numbers"}));
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
  const auto lens = LensOfWords(word, numbers);
  if (!lens.ok()) return part.Bad(absl::StrCat(part.Named("lens"), ": ", lens.status().message()));
  camera.raw.lens = *lens;
  return camera;
}

absl::Status ReadCameras(const Part& top, Rig& rig) {
  const YAML::Node list = top["cameras"];
  if (!list.IsDefined() || !list.IsSequence() || list.size() == 0) {
    return top.Bad("cameras is missing: a list of a left and a right one, or of one with depth");
  }
  for (size_t i = 0; i < list.size(); ++i) {
    const Part part(top.path(), absl::StrCat("cameras[", i, "]."), list[i]);
    ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(part));
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

absl::Status ReadDepth(const Part& top, Rig& rig) {
  if (!top.Has("depth")) return top.Bad("depth is missing, which RGB-D cameras have");
  const Part part(top.path(), "depth.", top["depth"]);
  RETURN_IF_ERROR(part.CheckFields({"units_per_m", "virtual_baseline_m"}));
  RETURN_IF_ERROR(part.Set("units_per_m", rig.depth.units_per_m));
  return part.Set("virtual_baseline_m", rig.depth.virtual_baseline_m);
}

absl::Status ReadKind(const Part& top, Rig& rig) {
  ASSIGN_OR_RETURN(const std::string kind, top.Word("kind"));
  std::set<std::string> known = {"rig",           "kind",    "cameras", "body_from_camera",
                                 "close_depth_m", "rate_hz", "mask"};
  if (kind == "stereo") {
    known.insert({"rectified", "baseline_m", "right_from_left", "widest_field_deg"});
  } else if (kind == "rgbd") {
    rig.kind = RigKind::kRgbd;
    known.insert("depth");
  } else {
    return top.Bad(absl::StrCat("kind is '", kind, "', must be stereo or rgbd"));
  }
  return top.CheckFields(known);
}

absl::Status ReadFormat(const Part& top) {
  double format = 0;
  RETURN_IF_ERROR(top.Set("rig", format));
  if (format == kFormat) return absl::OkStatus();
  return top.Bad(absl::StrCat("rig is ", format, ": 'rig: ", kFormat,
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
  RETURN_IF_ERROR(rig.kind == RigKind::kStereo ? ReadStereoFields(top, rig) : ReadDepth(top, rig));
  if (top.Has("body_from_camera")) {
    ASSIGN_OR_RETURN(rig.body_from_camera, top.Motion("body_from_camera"));
  }
  RETURN_IF_ERROR(top.Set("close_depth_m", rig.close_depth_m));
  RETURN_IF_ERROR(top.Set("rate_hz", rig.rate_hz));
  RETURN_IF_ERROR(ReadMaskPath(top, rig));
  const absl::Status possible = Validate(rig);
  return possible.ok() ? possible : top.Bad(possible.message());
}

std::string Listed(const std::vector<double>& numbers) {
  return absl::StrCat("[",
                      absl::StrJoin(numbers, ", ",
                                    [](std::string* out, double number) {
                                      absl::StrAppend(out, FormatReal(number));
                                    }),
                      "]");
}

std::string Listed(const Rigid3d& motion) {
  const Eigen::Matrix3d r = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = motion.translation;
  std::vector<double> rows;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rows.push_back(r(i, k));
    rows.push_back(t(i));
  }
  rows.insert(rows.end(), {0, 0, 0, 1});
  return Listed(rows);
}

void AppendCamera(const RigCamera& camera, std::string& text) {
  const RawCamera& raw = camera.raw;
  absl::StrAppend(&text, "  - size_px: [", camera.width_px, ", ", camera.height_px, "]\n");
  absl::StrAppend(&text, "    focal_px: ", Listed({raw.fx_px, raw.fy_px}), "\n");
  absl::StrAppend(&text, "    principal_px: ", Listed({raw.cx_px, raw.cy_px}), "\n");
  const std::vector<double> numbers = NumbersOf(raw.lens);
  if (numbers.empty()) return;
  absl::StrAppend(&text, "    lens: ", std::string(NameOf(raw.lens)), "\n");
  absl::StrAppend(&text, "    lens_numbers: ", Listed(numbers), "\n");
}

void AppendKind(const Rig& rig, std::string& text) {
  if (rig.kind == RigKind::kRgbd) {
    absl::StrAppend(&text, "depth:\n  units_per_m: ", FormatReal(rig.depth.units_per_m),
                    "\n  virtual_baseline_m: ", FormatReal(rig.depth.virtual_baseline_m), "\n");
    return;
  }
  absl::StrAppend(&text, "rectified: ", rig.rectified ? "true" : "false", "\n");
  if (rig.rectified) {
    absl::StrAppend(&text, "baseline_m: ", FormatReal(rig.baseline_m), "\n");
    return;
  }
  absl::StrAppend(&text, "right_from_left: ", Listed(rig.right_from_left), "\n");
  if (rig.widest_field_deg != Rig().widest_field_deg) {
    absl::StrAppend(&text, "widest_field_deg: ", FormatReal(rig.widest_field_deg), "\n");
  }
}

}  // namespace

absl::StatusOr<Rig> ReadRigFile(const std::string& path) {
  Rig rig;
  RETURN_IF_ERROR(UseYamlFields(
      path, [&](const YAML::Node& file) { return ReadAll(Part(path, "", file), rig); }));
  return rig;
}

std::string FormatRig(const Rig& rig, const std::string& origin) {
  std::string text =
      absl::StrCat("# A rig file of CORB-SLAM (docs/rig.md), made of ", origin, "\nrig: ", kFormat,
                   "\nkind: ", rig.kind == RigKind::kStereo ? "stereo" : "rgbd", "\ncameras:\n");
  for (const RigCamera& camera : rig.cameras) AppendCamera(camera, text);
  AppendKind(rig, text);
  if (rig.body_from_camera.has_value()) {
    absl::StrAppend(&text, "body_from_camera: ", Listed(*rig.body_from_camera), "\n");
  }
  if (rig.close_depth_m.has_value()) {
    absl::StrAppend(&text, "close_depth_m: ", FormatReal(*rig.close_depth_m), "\n");
  }
  if (rig.rate_hz.has_value()) absl::StrAppend(&text, "rate_hz: ", FormatReal(*rig.rate_hz), "\n");
  if (!rig.mask_file.empty()) absl::StrAppend(&text, "mask: ", rig.mask_file, "\n");
  return text;
}

}  // namespace corbslam::client_agent
