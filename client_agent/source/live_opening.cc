#include "client_agent/source/live_opening.h"

#include <variant>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

bool IsPlain(const SourceSpec& spec) {
  const FrameSelection& frames = spec.selection;
  const FrameSelection all;
  return !spec.one_camera && frames.first == all.first && !frames.last.has_value() &&
         frames.stride == all.stride && !frames.reverse && !frames.part.has_value() &&
         spec.perturbation.gamma == Perturbation().gamma &&
         spec.perturbation.noise_sigma == Perturbation().noise_sigma;
}

absl::Status CheckPlain(const SourceSpec& spec) {
  if (IsPlain(spec)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(FormatSourceSpec(spec),
                   ": a camera's frames are played as they come: frames, stride, reverse, robot, "
                   "gamma and noise are of recordings, and so is cameras=1: give the rig of one "
                   "camera (kind: monocular, docs/rig.md)"));
}

}  // namespace

bool IsLive(const SourceSpec& spec) { return spec.settings != nullptr && spec.settings->is_live(); }

absl::Status CheckLiveSource(const SourceSpec& spec) {
  RETURN_IF_ERROR(CheckPlain(spec));
  return spec.settings->CheckLive();
}

absl::StatusOr<LiveSource> OpenLiveSource(const SourceSpec& spec, const absl::Notification& stop) {
  RETURN_IF_ERROR(CheckPlain(spec));
  LiveSource opened;
  ASSIGN_OR_RETURN(opened.stream, spec.settings->OpenLive(stop));
  opened.description.is_live = true;
  opened.description.layout = absl::StrCat(spec.settings->kind(), ", live");
  opened.description.intrinsics_from = "its rig";
  opened.description.depth_units_from = "its rig";
  opened.description.times_from = "the camera's own, as its frames come";
  DescribeCamera(opened.stream->calibration(), opened.description);
  const bool has_imu = std::visit([](const auto& kind) { return kind.imu.has_value(); },
                                  opened.stream->calibration());
  if (has_imu) opened.description.imu = "as its samples come, by its rig";
  return opened;
}

}  // namespace corbslam::client_agent
