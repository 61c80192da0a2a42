#include "client_agent/source/rig_opening.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/pictures/image_file.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::string_view NameOf(RigKind kind) {
  return kind == RigKind::kStereo ? "a stereo pair" : "an RGB-D camera";
}

absl::Status CheckSize(const SourceSpec& spec, const RigCamera& camera,
                       const std::vector<ListedFrame>& frames) {
  std::vector<std::string> pictures;
  for (const ListedFrame& frame : frames) pictures.push_back(frame.first);
  ASSIGN_OR_RETURN(const cv::Mat first, ReadFirstGrey(pictures));
  if (first.cols == camera.width_px && first.rows == camera.height_px) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(spec.opening.rig_file, ": is of pictures of ", camera.width_px, "x",
                   camera.height_px, " pixels, ", pictures.front(), " has ", first.cols, "x",
                   first.rows, ": give the rig of this camera, at this size"));
}

}  // namespace

absl::Status TakeRig(const SourceSpec& spec, RigKind kind, ListedSequence& sequence) {
  const std::string& path = spec.opening.rig_file;
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(path));
  if (rig.kind != kind) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": is of ", NameOf(rig.kind), ", this recording is of ", NameOf(kind)));
  }
  RETURN_IF_ERROR(CheckSize(spec, rig.cameras[0], sequence.frames));
  ASSIGN_OR_RETURN(SourceFindings findings, JudgeRig(rig, path, spec.opening.trust_calibration));
  ASSIGN_OR_RETURN(sequence.calibration, CalibrationOf(rig));
  sequence.description.remarks.Add(std::move(findings));
  sequence.description.intrinsics_from = path;
  sequence.description.depth_units_from = path;
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
