#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// A matrix by its rows, and the file that has it.
struct Found {
  std::vector<double> numbers;
  std::string path;
};
// What the files hold, by name.
using Matrices = std::map<std::string, Found>;

absl::Status Collect(const YAML::Node& file, const std::string& path, Matrices& matrices) {
  for (const auto& entry : file) {
    const std::string name = entry.first.Scalar();
    const YAML::Node data = entry.second.IsMap() ? entry.second["data"] : entry.second;
    if (!data.IsDefined() || !data.IsSequence()) continue;
    const auto numbers = ReadNumbers(data, path, name, 1, 64);
    if (!numbers.ok()) continue;
    const auto [known, is_new] = matrices.try_emplace(name, Found{*numbers, path});
    if (is_new || known->second.numbers == *numbers) continue;
    return absl::InvalidArgumentError(absl::StrCat(name, " differs in ", known->second.path,
                                                   " and ", path,
                                                   ": give those of one calibration"));
  }
  return absl::OkStatus();
}

// Returns the first of `names` that is there.
absl::StatusOr<Found> Find(const Matrices& matrices, const std::vector<std::string>& names,
                           size_t least, size_t most, const RigFiles& files) {
  for (const std::string& name : names) {
    const auto found = matrices.find(name);
    if (found == matrices.end()) continue;
    const size_t count = found->second.numbers.size();
    if (count >= least && count <= most) return found->second;
    return absl::InvalidArgumentError(absl::StrCat(found->second.path, ": ", name, " has ", count,
                                                   " numbers, wanted are ", least, " to ", most));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(absl::StrJoin(files.paths, ", "), ": no ", absl::StrJoin(names, ", "),
                   ": give the intrinsics' file and the extrinsics'"));
}

// calibrateCamera's four numbers look like cv::fisheye's, and mean something else.
absl::StatusOr<LensModel> ReadLens(const Found& d, const std::string& name, const RigFiles& files) {
  const bool known =
      files.lens.empty() || files.lens == "radial-tangential" || files.lens == "equidistant";
  if (!known) {
    return absl::InvalidArgumentError(
        absl::StrCat("--lens is '", files.lens, "', must be radial-tangential or equidistant"));
  }
  if (files.lens.empty() && d.numbers.size() == 4) {
    return absl::InvalidArgumentError(
        absl::StrCat(d.path, ": ", name,
                     " has 4 numbers: of cv::fisheye (k1 k2 k3 k4) give --lens equidistant, of "
                     "calibrateCamera (k1 k2 p1 p2) --lens radial-tangential"));
  }
  const auto lens = LensOfName(files.lens.empty() ? "radial-tangential" : files.lens, d.numbers);
  if (lens.ok()) return lens;
  return absl::InvalidArgumentError(
      absl::StrCat(d.path, ": ", name, ": ", lens.status().message()));
}

absl::StatusOr<RigCamera> ReadCamera(const Matrices& matrices, int number, const RigFiles& files) {
  const std::string n = absl::StrCat(number);
  ASSIGN_OR_RETURN(const Found k,
                   Find(matrices, {"M" + n, "K" + n, "cameraMatrix" + n}, 9, 9, files));
  ASSIGN_OR_RETURN(const Found d,
                   Find(matrices, {"D" + n, "distCoeffs" + n, "dist" + n}, 4, 14, files));
  RETURN_IF_ERROR(CheckCameraMatrix(k.numbers, k.path, "M" + n));
  ASSIGN_OR_RETURN(const PictureSize size, NeedSize(files));
  ASSIGN_OR_RETURN(const LensModel lens, ReadLens(d, "D" + n, files));
  RigCamera camera;
  camera.raw = {k.numbers[0], k.numbers[4], k.numbers[2], k.numbers[5], lens};
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  return camera;
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadOpenCvStereo(const RigFiles& files) {
  Matrices matrices;
  for (const std::string& path : files.paths) {
    RETURN_IF_ERROR(
        UseYamlFields(path, [&](const YAML::Node& file) { return Collect(file, path, matrices); }));
  }
  ConvertedRig converted;
  Rig& rig = converted.rig;
  for (const int number : {1, 2}) {
    ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(matrices, number, files));
  }
  ASSIGN_OR_RETURN(const Found r, Find(matrices, {"R"}, 9, 9, files));
  ASSIGN_OR_RETURN(const Found t, Find(matrices, {"T"}, 3, 3, files));
  const std::vector<double>& m = r.numbers;
  ASSIGN_OR_RETURN(rig.right_from_left,
                   ToRigid({m[0], m[1], m[2], t.numbers[0], m[3], m[4], m[5], t.numbers[1], m[6],
                            m[7], m[8], t.numbers[2], 0, 0, 0, 1},
                           r.path, "R and T"));
  converted.notes.push_back(absl::StrCat(
      "T says that the cameras are ", rig.right_from_left.translation.norm(),
      " m apart: it has the unit in which the board's squares were given, which must be metres"));
  return converted;
}

}  // namespace corbslam::client_agent
