#include "client_agent/source/rgbd_opening.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/calibration/rgbd_calibration.h"
#include "client_agent/source/pictures/image_file.h"
#include "client_agent/source/rig_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

namespace {

// Returns the folder that holds `path`, which lies in `directory`, under the same name without
// links: the recording that a folder of links shows. Empty where there is none.
std::string RealFolder(const std::string& directory, const std::string& path) {
  std::error_code error;
  std::string real = std::filesystem::canonical(path, error).string();
  if (error || !absl::StartsWith(path, directory + "/")) return "";
  const absl::string_view name = absl::string_view(path).substr(directory.size());
  return absl::EndsWith(real, name) ? real.substr(0, real.size() - name.size()) : "";
}

// Makes the query of the options and the first picture that can be read.
absl::StatusOr<RgbdCalibrationQuery> MakeCalibrationQuery(const SourceSpec& spec,
                                                          const std::vector<ListedFrame>& frames) {
  std::vector<std::string> pictures;
  for (const ListedFrame& frame : frames) pictures.push_back(frame.first);
  ASSIGN_OR_RETURN(const cv::Mat first, ReadFirstGrey(pictures));
  RgbdCalibrationQuery query;
  query.folders = {spec.directory};
  for (const std::string& path : {frames.front().first, frames.front().second}) {
    const std::string real = RealFolder(spec.directory, path);
    if (!real.empty()) query.folders.push_back(real);
  }
  query.file = spec.opening.calibration_file;
  query.camera = spec.opening.camera;
  query.first_picture = pictures.front();
  query.width_px = first.cols;
  query.height_px = first.rows;
  query.trust = spec.opening.trust_calibration;
  return query;
}

}  // namespace

absl::Status CalibrateRgbd(const SourceSpec& spec, ListedSequence& sequence) {
  if (!spec.opening.rig_file.empty()) return TakeRig(spec, RigKind::kRgbd, sequence);
  if (spec.opening.registers.value_or(false)) {
    return absl::InvalidArgumentError(absl::StrCat(
        spec.directory,
        ": ?register=1 needs a rig (?rig=FILE) that says through which lens depth is "
        "measured (depth.camera) and where that camera sits (depth.colour_from_depth)"));
  }
  ASSIGN_OR_RETURN(const RgbdCalibrationQuery query, MakeCalibrationQuery(spec, sequence.frames));
  ASSIGN_OR_RETURN(FoundRgbdCalibration found, FindRgbdCalibration(query));
  SourceDescription& description = sequence.description;
  sequence.calibration = found.calibration;
  description.intrinsics_from = std::move(found.from);
  description.depth_units_from = std::move(found.depth_units_from);
  description.remarks.Add(std::move(found.findings));
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
