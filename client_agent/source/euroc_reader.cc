#include <filesystem>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/euroc_calibration.h"
#include "client_agent/source/calibration/plausibility.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/imu_opening.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/lists/camera_list.h"
#include "client_agent/source/rig_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::Status CheckCamera(const EurocCamera& camera, const std::string& path, bool trust,
                         SourceRemarks& remarks) {
  const RawCamera& k = camera.intrinsics;
  ASSIGN_OR_RETURN(SourceFindings findings, CheckIntrinsics({k.fx_px, k.fy_px, k.cx_px, k.cy_px,
                                                             camera.width_px, camera.height_px},
                                                            path, trust));
  remarks.Add(std::move(findings));
  return absl::OkStatus();
}

// Returns what cam0 says, whatever there is beside it.
absl::StatusOr<MonocularCalibration> ReadFirstCalibration(const std::string& root, bool trust,
                                                          SourceRemarks& remarks) {
  const std::string path = root + "/cam0/sensor.yaml";
  ASSIGN_OR_RETURN(const EurocCamera first, ReadEurocCamera(path));
  RETURN_IF_ERROR(CheckCamera(first, path, trust, remarks));
  const RawCamera& raw = first.intrinsics;
  return MonocularCalibration{.camera = {.fx_px = raw.fx_px,
                                         .fy_px = raw.fy_px,
                                         .cx_px = raw.cx_px,
                                         .cy_px = raw.cy_px,
                                         .width_px = first.width_px,
                                         .height_px = first.height_px},
                              .lens = raw.lens,
                              .body_from_raw = first.body_from_camera};
}

absl::StatusOr<SensorCalibration> ReadCalibration(const std::string& root, bool trust,
                                                  SourceRemarks& remarks) {
  const std::string left_path = root + "/cam0/sensor.yaml";
  const std::string right_path = root + "/cam1/sensor.yaml";
  ASSIGN_OR_RETURN(const EurocCamera left, ReadEurocCamera(left_path));
  ASSIGN_OR_RETURN(const EurocCamera right, ReadEurocCamera(right_path));
  if (left.width_px != right.width_px || left.height_px != right.height_px) {
    return absl::InvalidArgumentError(absl::StrCat(root, ": cam0 and cam1 differ in resolution"));
  }
  RawStereo raw;
  raw.left = left.intrinsics;
  raw.right = right.intrinsics;
  raw.right_from_left = right.body_from_camera.Inverse() * left.body_from_camera;
  raw.width_px = left.width_px;
  raw.height_px = left.height_px;
  if (const absl::Status status = Validate(raw); !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(root, ": ", status.message()));
  }
  RETURN_IF_ERROR(CheckCamera(left, left_path, trust, remarks));
  RETURN_IF_ERROR(CheckCamera(right, right_path, trust, remarks));
  const double baseline_m = raw.right_from_left.translation.norm();
  ASSIGN_OR_RETURN(SourceFindings findings,
                   CheckBaseline(baseline_m, absl::StrCat(root, ": T_BS of cam0 and cam1"), trust));
  remarks.Add(std::move(findings));
  StereoCalibration calibration;
  calibration.camera.close_depth_m = kEurocCloseDepth_baselines * baseline_m;
  calibration.raw = raw;
  calibration.body_from_raw_left = left.body_from_camera;
  return calibration;
}

absl::StatusOr<std::vector<ListedFrame>> ListFirst(const std::string& root,
                                                   SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(const auto pictures, ReadCameraList(root + "/cam0", remarks));
  std::vector<ListedFrame> frames;
  for (const ListedPicture& picture : pictures) {
    frames.push_back(
        {picture.timestamp_ns, 0, absl::StrCat(root, "/cam0/data/", picture.file), ""});
  }
  if (!frames.empty()) return frames;
  return absl::InvalidArgumentError(absl::StrCat(root, "/cam0/data.csv: lists no picture"));
}

absl::Status NoPairs(const std::string& root, const std::vector<ListedPicture>& left,
                     const std::vector<ListedPicture>& right) {
  if (left.empty() || right.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(root, left.empty() ? "/cam0" : "/cam1", "/data.csv: lists no picture"));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(root, ": cam0 and cam1 have no common times: cam0 lists ",
                   left.front().timestamp_ns, " to ", left.back().timestamp_ns, ", cam1 ",
                   right.front().timestamp_ns, " to ", right.back().timestamp_ns, " ns"));
}

// The right pictures were taken `right_offset_ns` later than they are stamped.
absl::StatusOr<std::vector<ListedFrame>> ListFrames(const std::string& root, int64_t tolerance_ns,
                                                    int64_t right_offset_ns,
                                                    SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(const auto left, ReadCameraList(root + "/cam0", remarks));
  ASSIGN_OR_RETURN(auto right, ReadCameraList(root + "/cam1", remarks));
  for (ListedPicture& picture : right) picture.timestamp_ns += right_offset_ns;
  std::vector<ListedFrame> frames;
  for (const auto& [first, second] : PairByTime(left, right, tolerance_ns, remarks)) {
    frames.push_back({first.timestamp_ns, 0, absl::StrCat(root, "/cam0/data/", first.file),
                      absl::StrCat(root, "/cam1/data/", second.file)});
  }
  if (frames.empty()) return NoPairs(root, left, right);
  return frames;
}

// Takes imu0 where it is there: where it sits is said by the rig, else by its sensor.yaml.
absl::Status TakeEurocImu(const SourceSpec& spec, const std::string& root,
                          ListedSequence& sequence) {
  std::error_code ignored;
  std::string list = root + "/imu0/data.csv";
  if (!std::filesystem::exists(list, ignored)) list.clear();
  const std::string sensor = root + "/imu0/sensor.yaml";
  const bool is_wanted = spec.opening.imu != "0" && !(list.empty() && spec.opening.imu.empty());
  if (is_wanted && spec.opening.rig_file.empty() && std::filesystem::exists(sensor, ignored)) {
    ASSIGN_OR_RETURN(EurocImu imu, ReadEurocImu(sensor));
    const MonocularCalibration first = FirstCameraOf(sequence.calibration);
    imu.stated.imu_from_camera = imu.body_from_imu.Inverse() * *first.body_from_raw;
    ASSIGN_OR_RETURN(SourceFindings findings,
                     JudgeImu(imu.stated, sensor, spec.opening.trust_calibration));
    sequence.description.remarks.Add(std::move(findings));
    sequence.imu = imu.stated;
  }
  return TakeImu(spec, list, sequence);
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenEuroc(const SourceSpec& spec) {
  const std::string root = EurocRoot(spec.directory);
  ASSIGN_OR_RETURN(const bool one_camera, PlaysOneCamera(spec));
  ListedSequence sequence;
  SourceDescription& description = sequence.description;
  const bool has_rig = !spec.opening.rig_file.empty();
  const bool trust = spec.opening.trust_calibration;
  if (!has_rig && one_camera) {
    ASSIGN_OR_RETURN(sequence.calibration, ReadFirstCalibration(root, trust, description.remarks));
  } else if (!has_rig) {
    ASSIGN_OR_RETURN(sequence.calibration, ReadCalibration(root, trust, description.remarks));
  }
  if (one_camera) {
    ASSIGN_OR_RETURN(sequence.frames, ListFirst(root, description.remarks));
  } else {
    const auto tolerance_ns = static_cast<int64_t>(1e6 * spec.opening.pair_within_ms);
    ASSIGN_OR_RETURN(const int64_t right_offset_ns, SecondTimeOffsetOf_ns(spec));
    ASSIGN_OR_RETURN(sequence.frames,
                     ListFrames(root, tolerance_ns, right_offset_ns, description.remarks));
  }
  sequence.paired_by_time = true;
  description.layout = one_camera ? "EuRoC (ASL), cam0" : "EuRoC (ASL), cam0 and cam1";
  description.intrinsics_from =
      absl::StrCat(root, "/cam0/sensor.yaml", one_camera ? "" : ", cam1/sensor.yaml");
  if (has_rig) RETURN_IF_ERROR(TakeRig(spec, RigKind::kStereo, sequence));
  RETURN_IF_ERROR(TakeEurocImu(spec, root, sequence));
  sequence.times_file = root + "/cam0/data.csv";
  return MakeListedReader(std::move(sequence));
}

}  // namespace corbslam::client_agent
