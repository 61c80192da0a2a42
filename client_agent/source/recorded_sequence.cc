#include "client_agent/source/recorded_sequence.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/kept_imu.h"
#include "client_agent/source/read_ahead.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Number of pictures that are decoded and not yet taken: enough to even out the disk, little
// memory.
constexpr size_t kReadAheadFrames = 3;

class ReadSequence : public RecordedSequence {
 public:
  ReadSequence(std::unique_ptr<FrameReader> reader, std::vector<size_t> frames,
               const Perturbation& perturbation)
      : reader_(std::move(reader)),
        frames_(std::move(frames)),
        perturbation_(perturbation),
        read_ahead_(kReadAheadFrames, [this](size_t i) { return Read(i); }) {}

  const SensorCalibration& calibration() const override { return reader_->calibration(); }
  size_t size() const override { return frames_.size(); }
  SourceFrame frame(size_t i) const override {
    return {frames_[i], reader_->timestamp_ns(frames_[i]), reader_->drive(frames_[i])};
  }
  absl::StatusOr<NextFrame> Next(absl::Time deadline) override;
  LeftOutFrames left_out() const override { return left_out_; }

 private:
  absl::StatusOr<std::optional<StreamFrame>> Read(size_t i) const {
    if (i == frames_.size()) return std::nullopt;
    ASSIGN_OR_RETURN(SensorImages images, ReadPerturbed(*reader_, frames_[i], perturbation_));
    return StreamFrame{frame(i), std::move(images)};
  }

  void AddImu(StreamFrame& frame);

  const std::unique_ptr<FrameReader> reader_;
  const std::vector<size_t> frames_;
  const Perturbation perturbation_;
  std::optional<int> imu_drive_;  // The drive of the frame that was given last.
  int64_t imu_until_ns_ = 0;      // The sample that was given last.
  bool has_failed_ = false;
  size_t unreadable_in_a_row_ = 0;
  LeftOutFrames left_out_;
  ReadAhead read_ahead_;  // The last member: its thread uses the others.
};

// Called for the frames that are given, so that what was measured before one that can't be read
// comes with the next.
void ReadSequence::AddImu(StreamFrame& frame) {
  if (!frame.images.imu.empty()) return;
  if (imu_drive_ != frame.frame.drive) {
    imu_drive_ = frame.frame.drive;
    imu_until_ns_ = frame.frame.timestamp_ns - kLongestKeptImu_ns;
  }
  frame.images.imu = reader_->Imu(imu_until_ns_, frame.frame.timestamp_ns);
  if (!frame.images.imu.empty()) imu_until_ns_ = frame.images.imu.back().timestamp_ns;
}

absl::StatusOr<NextFrame> ReadSequence::Next(absl::Time /*deadline*/) {
  while (!has_failed_) {
    absl::StatusOr<std::optional<StreamFrame>> frame = read_ahead_.Next();
    if (frame.ok() && !frame->has_value()) break;
    if (frame.ok()) {
      unreadable_in_a_row_ = 0;
      AddImu(**frame);
      return **std::move(frame);
    }
    ++left_out_.count;
    left_out_.last = std::string(frame.status().message());
    if (++unreadable_in_a_row_ < kMaxUnreadableInARow) continue;
    has_failed_ = true;
    return absl::Status(
        frame.status().code(),
        absl::StrCat(kMaxUnreadableInARow, " frames in a row can't be read, the last because of ",
                     left_out_.last));
  }
  return StreamEnd();
}

}  // namespace

std::optional<double> RecordedSequence::interval_s() const {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < size(); ++i) {
    const SourceFrame before = frame(i - 1);
    const SourceFrame after = frame(i);
    if (before.drive != after.drive) continue;
    // A sequence that is played backwards has falling times.
    const auto interval_ns = static_cast<double>(after.timestamp_ns - before.timestamp_ns);
    intervals_s.push_back(std::abs(interval_ns) * 1e-9);
  }
  if (intervals_s.empty()) return std::nullopt;
  return MeanMedian(std::move(intervals_s));
}

absl::StatusOr<std::optional<SensorImages>> RecordedSequence::NextImages() {
  ASSIGN_OR_RETURN(NextFrame next, Next(absl::InfiniteFuture()));
  if (auto* frame = std::get_if<StreamFrame>(&next)) return std::move(frame->images);
  return std::nullopt;
}

absl::StatusOr<std::unique_ptr<RecordedSequence>> OpenSource(const SourceSpec& spec) {
  ASSIGN_OR_RETURN(std::unique_ptr<FrameReader> reader, OpenReader(spec));
  return PlayReader(std::move(reader), spec);
}

absl::StatusOr<std::unique_ptr<RecordedSequence>> PlayReader(std::unique_ptr<FrameReader> reader,
                                                             const SourceSpec& spec) {
  std::vector<size_t> frames = FramesOf(spec, reader->frame_count());
  if (frames.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "source ", FormatSourceSpec(spec), " selects none of ", reader->frame_count(), " frames"));
  }
  return std::make_unique<ReadSequence>(std::move(reader), std::move(frames), spec.perturbation);
}

absl::StatusOr<std::unique_ptr<RecordedSequence>> OpenSource(absl::string_view spec) {
  ASSIGN_OR_RETURN(const SourceSpec parsed, ParseSourceSpec(spec));
  return OpenSource(parsed);
}

}  // namespace corbslam::client_agent
