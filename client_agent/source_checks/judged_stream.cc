#include "client_agent/source_checks/judged_stream.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/source/kept_imu.h"
#include "client_agent/source_checks/source_checks.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Returns whether nothing right can come of the pair.
bool IsHopeless(const SourceFinding& finding) {
  const bool is_same = finding.code == "pair-same-picture" && finding.level == FindingLevel::kError;
  return is_same || finding.code == "pair-exchanged" || finding.code == "pair-late";
}

// What an IMU measured before a frame that is passed over comes with the newer one.
StreamFrame InPlaceOf(std::optional<StreamFrame> passed_over, StreamFrame newer) {
  KeptImu kept;
  if (passed_over.has_value()) {
    kept.Keep(passed_over->frame.drive, std::move(passed_over->images.imu));
  }
  kept.GiveTo(newer.frame.drive, newer.images.imu);
  return newer;
}

}  // namespace

void LateWatch::Offer(const StreamFrame& frame, absl::Time now) {
  if (judgements_ == kMostJudgements || judging_.valid() || now < next_) return;
  if (!row_.empty() && row_.back().number + 1 != frame.frame.number) row_.clear();
  row_.push_back({frame.frame.number, frame.images});
  if (row_.size() < kFrames) return;
  ++judgements_;
  judging_ = StartAsync("late watch", [this, row = std::exchange(row_, {})] {
    return JudgeSample(calibration_, row);
  });
}

std::optional<SourceFinding> LateWatch::Take(bool waits, absl::Time now) {
  if (!judging_.valid()) return std::nullopt;
  if (!waits && judging_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return std::nullopt;
  }
  StereoJudgement judgement = judging_.get();
  next_ = now + kBetweenJudgements;
  const auto late = std::find_if(judgement.findings.begin(), judgement.findings.end(),
                                 [](const auto& found) { return found.code == "pair-late"; });
  if (late == judgement.findings.end()) return std::nullopt;
  judgements_ = kMostJudgements;
  return std::move(*late);
}

JudgedStream::JudgedStream(std::unique_ptr<FrameStream> stream, const JudgedStreamOptions& options)
    : stream_(std::move(stream)),
      options_(options),
      judges_(KindOf(stream_->calibration()) == SensorKind::kStereo) {
  if (judges_) late_.emplace(stream_->calibration());
}

absl::StatusOr<NextFrame> JudgedStream::Next(absl::Time deadline) {
  if (ended_) return StreamEnd();
  if (behind_.has_value()) {
    absl::StatusOr<NextFrame> next = *std::move(behind_);
    behind_.reset();
    return Watch(std::move(next));
  }
  if (!judges_) return Watch(stream_->Next(deadline));
  const absl::Time until = waiting_.has_value() ? std::min(deadline, waiting_until_) : deadline;
  return Hold(stream_->Next(until), absl::Now());
}

absl::StatusOr<NextFrame> JudgedStream::Watch(absl::StatusOr<NextFrame> next) {
  if (!late_.has_value() || !next.ok()) return next;
  const absl::Time now = absl::Now();
  if (const auto* frame = std::get_if<StreamFrame>(&*next)) late_->Offer(*frame, now);
  std::optional<SourceFinding> found =
      late_->Take(/*waits=*/std::holds_alternative<StreamEnd>(*next), now);
  if (!found.has_value()) return next;
  late_.reset();
  if (absl::Status wrong = Tell(*std::move(found)); !wrong.ok()) {
    ended_ = true;
    return wrong;
  }
  return next;
}

absl::StatusOr<NextFrame> JudgedStream::Hold(absl::StatusOr<NextFrame> next, absl::Time now) {
  if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) {
    judges_ = false;
    if (!waiting_.has_value()) return next;
    behind_ = std::move(next);
    return Release();
  }
  if (auto* frame = std::get_if<StreamFrame>(&*next)) {
    if (waiting_until_ == absl::InfiniteFuture()) waiting_until_ = now + kMaxWait;
    sample_.push_back({frame->frame.number, frame->images});
    if (waiting_.has_value()) ++skipped_;
    waiting_ = InPlaceOf(std::move(waiting_), std::move(*frame));
    if (sample_.size() == wanted_) {
      if (absl::Status wrong = Judge(); !wrong.ok()) {
        ended_ = true;
        return wrong;
      }
      if (wanted_ == kFrames || !judges_) return Release();
      waiting_until_ = absl::Now() + kMaxWait;
    }
  }
  if (!waiting_.has_value() || now < waiting_until_) return NoFrameYet();
  return Release();
}

absl::Status JudgedStream::Judge() {
  StereoJudgement judgement = JudgeSample(stream_->calibration(), sample_);
  sample_.clear();
  // Dark or covered pictures are no error of a camera's: somebody may turn on the light.
  const bool is_hopeless = std::ranges::any_of(judgement.findings, IsHopeless);
  judges_ = !is_hopeless && judgement.pairs.size() < kFrames && ++tries_ < kMostTries;
  if (judges_) return absl::OkStatus();
  if (wanted_ == kFrames && MayBeLate(judgement)) {
    wanted_ = kFramesOfSecondTry;
    judges_ = true;
    return absl::OkStatus();
  }
  for (SourceFinding& finding : judgement.findings) {
    if (finding.code == "pair-late") late_.reset();
    RETURN_IF_ERROR(Tell(std::move(finding)));
  }
  return absl::OkStatus();
}

absl::Status JudgedStream::Tell(SourceFinding finding) {
  const std::string text = absl::StrCat(finding.text, " [", finding.code, "]");
  if (options_.strict || (IsHopeless(finding) && !options_.trust_calibration)) {
    return absl::InvalidArgumentError(
        absl::StrCat(text, options_.strict ? "" : ". If that is not so, say ?trust-calibration"));
  }
  LOG(WARNING) << text;
  finding.level = FindingLevel::kWarning;
  findings_.push_back(std::move(finding));
  return absl::OkStatus();
}

absl::StatusOr<NextFrame> JudgedStream::Release() {
  StreamFrame frame = *std::move(waiting_);
  waiting_.reset();
  if (behind_.has_value()) return frame;
  absl::StatusOr<NextFrame> newest = stream_->Next(absl::InfinitePast());
  if (!newest.ok() || std::holds_alternative<StreamEnd>(*newest)) {
    judges_ = false;
    behind_ = std::move(newest);
  } else if (auto* const newer = std::get_if<StreamFrame>(&*newest)) {
    ++skipped_;
    return InPlaceOf(std::move(frame), std::move(*newer));
  }
  return frame;
}

SourceFindings JudgedStream::findings() const {
  SourceFindings all = stream_->findings();
  all.insert(all.end(), findings_.begin(), findings_.end());
  return all;
}

}  // namespace corbslam::client_agent
