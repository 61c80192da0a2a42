// Judges the first frames of a live pair before anybody maps what they show.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_JUDGED_STREAM_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_JUDGED_STREAM_H_

#include <cstddef>
#include <future>
#include <memory>
#include <optional>

#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"
#include "client_agent/source_checks/stereo_checks.h"

namespace corbslam::client_agent {

// Three frames hardly show a late camera, and a robot that stands shows none: frames in a row are
// judged a few times, on a thread of their own, while the stream goes on. One thread uses it.
class LateWatch {
 public:
  static constexpr size_t kFrames = 8;
  static constexpr int kMostJudgements = 5;
  static constexpr absl::Duration kBetweenJudgements = absl::Seconds(2);

  explicit LateWatch(const SensorCalibration& calibration) : calibration_(calibration) {}

  // Notes a frame that passes. Its pictures are kept for a while: nobody may change them.
  void Offer(const StreamFrame& frame, absl::Time now);
  // Returns what a judgement found since the last call, once; `waits` for one that is under way.
  std::optional<SourceFinding> Take(bool waits, absl::Time now);

 private:
  const SensorCalibration calibration_;
  Sample row_;
  int judgements_ = 0;
  absl::Time next_ = absl::InfinitePast();
  std::future<StereoJudgement> judging_;
};

struct JudgedStreamOptions {
  // A pair of which nothing right can come is taken, with a warning.
  bool trust_calibration = false;
  // Every finding is refused.
  bool strict = false;
};

// Gives the frames of a camera once three of them that could be judged were: those before are
// counted as overtaken, for the newest one wins. A camera that gives a frame only when the one
// before was used is not kept waiting for longer than kMaxWait; its frames are judged in passing.
// Where nothing can be judged (a dark start) the next frames are, kMostTries times; and where a
// late camera may be what is wrong, which three frames do not show, the next kFramesOfSecondTry.
// In passing LateWatch looks on.
//
// What is found is logged. A pair that is exchanged, a frame late or twice the same picture ends
// the stream with INVALID_ARGUMENT; other errors of a recorded pair are warnings here, for a second
// of a camera shows less than a recording does.
class JudgedStream : public FrameStream {
 public:
  static constexpr absl::Duration kMaxWait = absl::Seconds(1);
  static constexpr size_t kFrames = 3;
  static constexpr size_t kFramesOfSecondTry = 8;
  static constexpr size_t kMostTries = 10;

  JudgedStream(std::unique_ptr<FrameStream> stream, const JudgedStreamOptions& options);

  const SensorCalibration& calibration() const override { return stream_->calibration(); }
  std::optional<double> interval_s() const override { return stream_->interval_s(); }
  absl::StatusOr<NextFrame> Next(absl::Time deadline) override;
  LeftOutFrames left_out() const override { return stream_->left_out(); }
  uint64_t overtaken() const override { return stream_->overtaken() + skipped_; }
  SourceFindings findings() const override;
  std::optional<CameraCounts> camera_counts() const override { return stream_->camera_counts(); }
  PoseListener* pose_listener() override { return stream_->pose_listener(); }
  bool is_live() const override { return stream_->is_live(); }

 private:
  // Takes one of the first frames, or what came in its place.
  absl::StatusOr<NextFrame> Hold(absl::StatusOr<NextFrame> next, absl::Time now);
  // Judges the sample. Returns what ends the stream.
  absl::Status Judge();
  // Logs a finding, or returns it where it ends the stream.
  absl::Status Tell(SourceFinding finding);
  // Returns what comes, or what a late camera makes of it.
  absl::StatusOr<NextFrame> Watch(absl::StatusOr<NextFrame> next);
  // Returns the newest frame there is.
  absl::StatusOr<NextFrame> Release();

  const std::unique_ptr<FrameStream> stream_;
  const JudgedStreamOptions options_;
  bool judges_;  // False once all is judged.
  size_t tries_ = 0;
  size_t wanted_ = kFrames;  // Of the sample.
  uint64_t skipped_ = 0;
  Sample sample_;
  std::optional<StreamFrame> waiting_;
  absl::Time waiting_until_ = absl::InfiniteFuture();
  // What came behind the last frame that waited.
  std::optional<absl::StatusOr<NextFrame>> behind_;
  bool ended_ = false;
  SourceFindings findings_;
  // Of a pair, until it is found late.
  std::optional<LateWatch> late_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_JUDGED_STREAM_H_
