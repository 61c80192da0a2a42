#include "client_agent/source_checks/late_watch.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client_agent/source_checks/source_checks.h"

namespace corbslam::client_agent {

void LateWatch::Offer(const StreamFrame& frame, absl::Time now) {
  if (looks_ == kMostLooks || look_.valid() || now < next_) return;
  if (!row_.empty() && row_.back().number + 1 != frame.frame.number) row_.clear();
  row_.push_back({frame.frame.number, frame.images});
  if (row_.size() < kFrames) return;
  ++looks_;
  look_ = std::async(std::launch::async, [this, row = std::exchange(row_, {})] {
    return JudgeSample(calibration_, row);
  });
}

std::optional<SourceFinding> LateWatch::Take(bool waits, absl::Time now) {
  if (!look_.valid()) return std::nullopt;
  if (!waits && look_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return std::nullopt;
  }
  StereoJudgement judgement = look_.get();
  next_ = now + kBetweenLooks;
  const auto late = std::find_if(judgement.findings.begin(), judgement.findings.end(),
                                 [](const auto& found) { return found.code == "pair-late"; });
  if (late == judgement.findings.end()) return std::nullopt;
  looks_ = kMostLooks;
  return std::move(*late);
}

}  // namespace corbslam::client_agent
