#include "services/programs/robot/robot_source.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "services/programs/robot/inspected_source.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameSelection;
using client_agent::FrameStream;
using client_agent::Perturbation;
using client_agent::SourceFinding;
using client_agent::SourceSpec;

namespace {

bool IsPlain(const SourceSpec& spec) {
  const FrameSelection& frames = spec.selection;
  const FrameSelection all;
  return frames.first == all.first && !frames.last.has_value() && frames.stride == all.stride &&
         !frames.reverse && !frames.part.has_value() &&
         spec.perturbation.gamma == Perturbation().gamma &&
         spec.perturbation.noise_sigma == Perturbation().noise_sigma;
}

absl::StatusOr<RobotSource> OpenCamera(const SourceSpec& spec) {
  if (!IsPlain(spec)) {
    return absl::InvalidArgumentError(
        absl::StrCat(FormatSourceSpec(spec),
                     ": a camera's frames are played as they come: frames, stride, reverse, robot, "
                     "gamma and noise are of recordings"));
  }
  RobotSource opened;
  ASSIGN_OR_RETURN(opened.stream, spec.settings->OpenLive());
  opened.description.is_live = true;
  opened.description.layout = absl::StrCat(spec.settings->kind(), ", live");
  opened.description.intrinsics_from = "its rig";
  opened.description.depth_units_from = "its rig";
  opened.description.times_from = "the camera's own, as its frames come";
  DescribeCamera(opened.stream->calibration(), opened.description);
  return opened;
}

}  // namespace

absl::StatusOr<RobotSource> OpenRobotSource(const SourceSpec& spec, bool strict) {
  if (spec.settings != nullptr && spec.settings->is_live()) return OpenCamera(spec);
  ASSIGN_OR_RETURN(InspectedSource inspected, OpenInspectedSource(spec, strict));
  return RobotSource{std::move(inspected.source), std::move(inspected.description),
                     std::move(inspected.warnings)};
}

void LogSource(const RobotSource& source) {
  LOG(INFO) << "the source:\n" << FormatDescription(source.description);
  for (const SourceFinding& warning : source.warnings) {
    LOG(WARNING) << warning.text << " [" << warning.code << "]";
  }
}

}  // namespace corbslam::services
