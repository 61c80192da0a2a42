#include "client_agent/source/rig_opening.h"

#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/pictures/image_file.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

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

// What is done to a camera's frames once.
struct Alignment {
  int64_t second_offset_ns = 0;
  bool registers_depth = false;
  double imu_offset_s = 0;
  bool operator==(const Alignment&) const = default;
};

Alignment AlignmentOf(const Rig& rig, std::optional<bool> registers) {
  const bool has_camera = rig.kind == RigKind::kRgbd && rig.depth.camera.has_value();
  return {SecondTimeOffset_ns(rig), has_camera && registers.value_or(true),
          rig.imu.has_value() ? rig.imu->time_offset_s : 0};
}

// A robot's recording (docs/recording.md) has frames as they were tracked: with aligned stamps and
// registered depth. Its own rig says so; the robot's would do both again.
absl::Status CheckNotDoneTwice(const SourceSpec& spec, const Rig& rig) {
  const std::filesystem::path folder(spec.directory);
  std::error_code ignored;
  if (!std::filesystem::exists(folder / "recording.json", ignored)) return absl::OkStatus();
  const std::string own_file = (folder / "rig.yaml").string();
  const absl::StatusOr<Rig> own = ReadRigFile(own_file);
  const Alignment done = own.ok() ? AlignmentOf(*own, spec.opening.registers) : Alignment();
  Alignment wanted = AlignmentOf(rig, spec.opening.registers);
  // Another list, or none, is by the IMU's own clock.
  const bool takes_own_imu = own.ok() && own->imu.has_value() && spec.opening.imu.empty();
  if (!takes_own_imu) wanted.imu_offset_s = done.imu_offset_s;
  if (wanted == done) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      spec.opening.rig_file, ": has another time_offset_s or depth.camera than ", own_file,
      ", and ", spec.directory,
      " holds what a robot tracked, whose stamps are aligned and whose depth is registered "
      "already: give --rig ",
      own_file));
}

}  // namespace

absl::StatusOr<bool> PlaysOneCamera(const SourceSpec& spec) {
  if (spec.one_camera || spec.opening.rig_file.empty()) return spec.one_camera;
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(spec.opening.rig_file));
  return rig.kind == RigKind::kMonocular;
}

void LeaveOutSecond(ListedSequence& sequence) {
  sequence.calibration = FirstCameraOf(sequence.calibration);
  sequence.depth = DepthPreparation();
  sequence.description.depth_registration.clear();
  for (ListedFrame& frame : sequence.frames) frame.second.clear();
}

absl::StatusOr<int64_t> SecondTimeOffsetOf_ns(const SourceSpec& spec) {
  if (spec.opening.rig_file.empty()) return 0;
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(spec.opening.rig_file));
  RETURN_IF_ERROR(CheckNotDoneTwice(spec, rig));
  return SecondTimeOffset_ns(rig);
}

absl::Status TakeRig(const SourceSpec& spec, RigKind kind, ListedSequence& sequence) {
  const std::string& path = spec.opening.rig_file;
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(path));
  const bool is_one = spec.one_camera || rig.kind == RigKind::kMonocular;
  if (rig.kind != kind && !is_one) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": is of ", NameOf(rig.kind), ", this recording is of ", NameOf(kind)));
  }
  RETURN_IF_ERROR(CheckNotDoneTwice(spec, rig));
  RETURN_IF_ERROR(CheckSize(spec, rig.cameras[0], sequence.frames));
  ASSIGN_OR_RETURN(SourceFindings findings, JudgeRig(rig, path, spec.opening.trust_calibration));
  ASSIGN_OR_RETURN(sequence.calibration, CalibrationOf(rig));
  sequence.imu = rig.imu;
  if (SecondTimeOffset_ns(rig) != 0 && !sequence.paired_by_time && !is_one) {
    findings.push_back({FindingLevel::kWarning, "time-offset-unused",
                        absl::StrCat(path,
                                     ": time_offset_s is not applied: this recording's pairs "
                                     "are told by their numbers, not by their times")});
  }
  if (kind == RigKind::kRgbd && !is_one) {
    absl::StatusOr<DepthPreparation> depth = DepthPreparation::Make(rig, spec.opening.registers);
    if (!depth.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": ", depth.status().message()));
    }
    sequence.description.depth_registration = depth->description();
    sequence.depth = *std::move(depth);
  }
  sequence.description.remarks.Add(std::move(findings));
  sequence.description.intrinsics_from = path;
  sequence.description.depth_units_from = path;
  if (is_one) LeaveOutSecond(sequence);
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
