#include "client_agent/source_checks/judged_stream.h"

#include <glog/logging.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/source_checks/source_checks.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

JudgedStream::JudgedStream(std::unique_ptr<FrameStream> stream, const JudgedStreamOptions& options)
    : stream_(std::move(stream)),
      options_(options),
      judges_(std::holds_alternative<StereoCalibration>(stream_->calibration())) {}

absl::StatusOr<NextFrame> JudgedStream::Next(absl::Time deadline) {
  if (ended_) return StreamEnd();
  if (behind_.has_value()) {
    absl::StatusOr<NextFrame> next = *std::move(behind_);
    behind_.reset();
    return next;
  }
  if (!judges_) return stream_->Next(deadline);
  const absl::Time until = held_.has_value() ? std::min(deadline, held_until_) : deadline;
  return Hold(stream_->Next(until), absl::Now());
}

absl::StatusOr<NextFrame> JudgedStream::Hold(absl::StatusOr<NextFrame> next, absl::Time now) {
  if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) {
    judges_ = false;
    if (!held_.has_value()) return next;
    behind_ = std::move(next);
    return Release();
  }
  if (auto* frame = std::get_if<StreamFrame>(&*next)) {
    if (held_until_ == absl::InfiniteFuture()) held_until_ = now + kMostHeld;
    sample_.push_back({frame->frame.number, frame->images});
    if (held_.has_value()) ++skipped_;
    held_ = std::move(*frame);
    if (sample_.size() == kFrames) {
      if (absl::Status wrong = Judge(); !wrong.ok()) {
        ended_ = true;
        return wrong;
      }
      return Release();
    }
  }
  if (!held_.has_value() || now < held_until_) return NoFrameYet();
  return Release();
}

absl::Status JudgedStream::Judge() {
  StereoJudgement judgement = JudgeSample(stream_->calibration(), sample_);
  sample_.clear();
  // Dark or covered pictures are no error of a camera's: somebody may turn on the light.
  judges_ = judgement.pairs.size() < kFrames && ++tries_ < kMostTries;
  if (judges_) return absl::OkStatus();
  for (SourceFinding& finding : judgement.findings) {
    const std::string text = absl::StrCat(finding.text, " [", finding.code, "]");
    const bool is_exchanged = finding.code == "pair-exchanged";
    if (options_.strict || (is_exchanged && !options_.trust_calibration)) {
      return absl::InvalidArgumentError(
          absl::StrCat(text, options_.strict ? "" : ". If they are not, say ?trust-calibration"));
    }
    LOG(WARNING) << text;
    finding.level = FindingLevel::kWarning;
    findings_.push_back(std::move(finding));
  }
  return absl::OkStatus();
}

absl::StatusOr<NextFrame> JudgedStream::Release() {
  StreamFrame frame = *std::move(held_);
  held_.reset();
  if (behind_.has_value()) return frame;
  absl::StatusOr<NextFrame> newest = stream_->Next(absl::InfinitePast());
  if (!newest.ok() || std::holds_alternative<StreamEnd>(*newest)) {
    judges_ = false;
    behind_ = std::move(newest);
  } else if (auto* const newer = std::get_if<StreamFrame>(&*newest)) {
    ++skipped_;
    return std::move(*newer);
  }
  return frame;
}

SourceFindings JudgedStream::findings() const {
  SourceFindings all = stream_->findings();
  all.insert(all.end(), findings_.begin(), findings_.end());
  return all;
}

}  // namespace corbslam::client_agent
