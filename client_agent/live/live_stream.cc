#include "client_agent/live/live_stream.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client_agent/source/imu_opening.h"
#include "client_agent/source/source_description.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Returns the size that pictures must have, as they are recorded.
cv::Size SizeOf(const SensorCalibration& calibration) {
  const Intrinsics recorded = RecordedIntrinsics(calibration);
  return {recorded.width_px, recorded.height_px};
}

absl::Status CheckPicture(absl::string_view which, const cv::Mat& image, int type,
                          const cv::Size& size) {
  if (image.type() == type && image.size() == size) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "a ", which, " picture of ", image.cols, "x", image.rows, " ", cv::typeToString(image.type()),
      ", the rig is of ", size.width, "x", size.height, " ", cv::typeToString(type)));
}

// Returns the offset that the frames' times need.
int64_t UsedOffset_ns(const Rig& rig, const LiveOptions& options) {
  return options.one_stamp ? 0 : SecondTimeOffset_ns(rig);
}

SourceFindings FindUnusedOffset(const Rig& rig, const LiveOptions& options) {
  const int64_t offset_ns = SecondTimeOffset_ns(rig);
  if (!options.one_stamp || offset_ns == 0) return {};
  SourceFinding finding{
      FindingLevel::kWarning, "time-offset-unused",
      absl::StrCat(options.name, ": the rig's second camera is ",
                   1e-6 * static_cast<double>(offset_ns),
                   " ms later by time_offset_s, which is not used: both pictures of a frame come "
                   "with one stamp here. If they were taken apart, trigger the cameras together")};
  LOG(WARNING) << finding.text << " [" << finding.code << "]";
  return {std::move(finding)};
}

absl::StatusOr<DepthPreparation> DepthOf(const Rig& rig, const LiveOptions& options) {
  if (rig.kind == RigKind::kRgbd) return DepthPreparation::Make(rig, options.registers);
  if (!options.registers.value_or(false)) return DepthPreparation();
  return absl::InvalidArgumentError(options.name + ": register=1 is of RGB-D rigs");
}

}  // namespace

absl::Status LiveStream::Check(const Rig& rig, const LiveOptions& options) {
  RETURN_IF_ERROR(CalibrationOf(rig).status());
  return DepthOf(rig, options).status();
}

absl::StatusOr<std::unique_ptr<FrameStream>> LiveStream::Open(const Rig& rig,
                                                              std::unique_ptr<LiveCamera> camera,
                                                              const LiveOptions& options) {
  ASSIGN_OR_RETURN(SensorCalibration calibration, CalibrationOf(rig));
  ASSIGN_OR_RETURN(DepthPreparation depth, DepthOf(rig, options));
  if (depth.registers()) LOG(INFO) << options.name << ": depth is " << depth.description();
  std::unique_ptr<LiveStream> stream(
      new LiveStream(rig, std::move(calibration), std::move(depth), std::move(camera), options));
  RETURN_IF_ERROR(stream->camera_->Start(stream->pairing_));
  return stream;
}

LiveStream::LiveStream(const Rig& rig, SensorCalibration calibration, DepthPreparation depth,
                       std::unique_ptr<LiveCamera> camera, const LiveOptions& options)
    : options_(options),
      rate_hz_(rig.rate_hz),
      calibration_(std::move(calibration)),
      depth_(std::move(depth)),
      pairing_(/*both=*/rig.kind != RigKind::kMonocular, options.pair_within_ns,
               UsedOffset_ns(rig, options)),
      rate_(rig.rate_hz),
      findings_(FindUnusedOffset(rig, options)),
      camera_(std::move(camera)) {
  UseImu(rig);
}

void LiveStream::UseImu(const Rig& rig) {
  if (!rig.imu.has_value()) return;
  if (LiveImu* const imu = camera_->imu(); imu != nullptr) {
    imu->SetOffset(std::llround(1e9 * rig.imu->time_offset_s));
    return;
  }
  SetImu(std::nullopt, calibration_);
  findings_.push_back({FindingLevel::kWarning, "imu-unused",
                       absl::StrCat(options_.name,
                                    ": the rig's IMU is not used: this camera gives no samples of "
                                    "it, as a driver behind push: can (docs/push.md)")});
  LOG(WARNING) << findings_.back().text << " [" << findings_.back().code << "]";
}

LiveStream::~LiveStream() { camera_->Stop(); }

std::optional<double> LiveStream::interval_s() const {
  if (rate_hz_.has_value()) return 1 / *rate_hz_;
  return rate_.usual_interval_s();
}

absl::StatusOr<NextFrame> LiveStream::Next(absl::Time deadline) {
  if (ended_) return StreamEnd();
  absl::StatusOr<std::optional<LivePair>> pair = pairing_.Take(deadline);
  if (!pair.ok()) {
    ended_ = true;
    if (absl::IsOutOfRange(pair.status())) return StreamEnd();
    return pair.status();
  }
  TellRate();
  if (!pair->has_value()) {
    if (const absl::Status paired = CheckPaired(); !paired.ok()) {
      ended_ = true;
      return paired;
    }
    return NoFrameYet();
  }
  absl::StatusOr<StreamFrame> frame = FrameOf(**pair);
  if (!frame.ok()) return LeaveOut(**pair, frame.status());
  wrong_in_a_row_ = 0;
  return *std::move(frame);
}

void LiveStream::TellRate() {
  const CameraCounts counts = pairing_.counts();
  const uint64_t pictures = counts.pictures[0] + counts.pictures[1];
  if (const auto told = rate_.Tell(absl::Now(), counts.frames); told.has_value()) {
    const bool come = rate_.is_stopped() && pictures > pictures_at_frame_ + kMostWrong;
    LOG(WARNING) << options_.name << ": " << *told
                 << (come ? absl::StrCat(", though pictures come: ", left_out().last) : "");
  }
  if (counts.frames == frames_) return;
  frames_ = counts.frames;
  pictures_at_frame_ = pictures;
}

absl::StatusOr<StreamFrame> LiveStream::FrameOf(const LivePair& pair) const {
  RETURN_IF_ERROR(CheckPictures(pair));
  StreamFrame frame;
  frame.frame = {pair.number, pair.first.timestamp_ns, pair.drive};
  frame.came = pair.came;
  frame.images.timestamp_ns = pair.first.timestamp_ns;
  frame.images.grey = pair.first.image;
  if (LiveImu* const imu = camera_->imu(); imu != nullptr) {
    frame.images.imu = imu->Take(frame.images.timestamp_ns);
  }
  const SensorKind kind = KindOf(calibration_);
  if (kind == SensorKind::kStereo) {
    frame.images.right = pair.second.image;
  } else if (kind == SensorKind::kRgbd) {
    ASSIGN_OR_RETURN(frame.images.depth, depth_.Prepare(pair.second.image));
  }
  return frame;
}

absl::Status LiveStream::CheckPaired() const {
  if (KindOf(calibration_) == SensorKind::kMonocular) return absl::OkStatus();
  const CameraCounts counts = pairing_.counts();
  if (counts.frames > 0 || std::min(counts.pictures[0], counts.pictures[1]) < kMostAlone) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      options_.name, ": ", counts.pictures[0], " and ", counts.pictures[1],
      " pictures came of the two cameras, and no two of one time", AdvicePairs(counts)));
}

absl::StatusOr<NextFrame> LiveStream::LeaveOut(const LivePair& pair, const absl::Status& why) {
  ++wrong_.count;
  wrong_.last = absl::StrCat(options_.name, ": frame ", pair.number, ": ", why.message());
  if (++wrong_in_a_row_ < kMostWrong) return NoFrameYet();
  ended_ = true;
  return absl::InvalidArgumentError(
      absl::StrCat(wrong_.last, ": give the rig of this camera (--rig), or set its format"));
}

std::string LiveStream::AdvicePairs(const CameraCounts& counts) const {
  if (counts.nearest_unpaired_ns == 0) return "";
  return absl::StrFormat(
      "; the nearest are %.1f ms apart, a frame's may be %.1f ms: do the cameras run freely? "
      "Trigger "
      "them together; where they are and only their stamps differ, say by how much (time_offset_s "
      "in "
      "the rig, ?pair-within-ms)",
      1e-6 * static_cast<double>(counts.nearest_unpaired_ns),
      1e-6 * static_cast<double>(options_.pair_within_ns));
}

absl::Status LiveStream::CheckPictures(const LivePair& pair) const {
  const bool stereo = KindOf(calibration_) == SensorKind::kStereo;
  const cv::Size size = SizeOf(calibration_);
  RETURN_IF_ERROR(CheckPicture(stereo ? "left" : "grey", pair.first.image, CV_8UC1, size));
  if (KindOf(calibration_) == SensorKind::kMonocular) return absl::OkStatus();
  return CheckPicture(stereo ? "right" : "depth", pair.second.image, stereo ? CV_8UC1 : CV_16UC1,
                      depth_.raw_size().value_or(size));
}

LeftOutFrames LiveStream::left_out() const {
  LeftOutFrames left_out = wrong_;
  const CameraCounts counts = pairing_.counts();
  left_out.count += counts.unpaired + counts.late + counts.ahead;
  if (left_out.last.empty() && left_out.count > 0) {
    left_out.last = absl::StrCat(options_.name, ": ", counts.unpaired,
                                 " pictures had no counterpart in time, and ", counts.late,
                                 " came behind a newer one");
    if (counts.unpaired > counts.frames) absl::StrAppend(&left_out.last, AdvicePairs(counts));
    if (counts.ahead > 0) {
      absl::StrAppend(
          &left_out.last, ", and ", counts.ahead,
          " were stamped more than a minute ahead of it: does the camera's driver stamp "
          "them by several clocks?");
    }
  }
  return left_out;
}

}  // namespace corbslam::client_agent
