#include "client_agent/live/stamp_watch.h"

namespace corbslam::client_agent {

StampWatch::Verdict StampWatch::Compare(int64_t stamp_ns, Moment came) const {
  if (!newest_.has_value()) return Verdict::kTake;
  if (stamp_ns <= newest_->stamp_ns) return Verdict::kLate;
  const std::chrono::nanoseconds most = kMostAhead + (came - newest_->came);
  // Stamps may be of any size: the difference of two may be none of 64 bits.
  const auto step_ns = static_cast<uint64_t>(stamp_ns) - static_cast<uint64_t>(newest_->stamp_ns);
  return step_ns > static_cast<uint64_t>(most.count()) ? Verdict::kAhead : Verdict::kTake;
}

StampWatch::Verdict StampWatch::Judge(int64_t stamp_ns, Moment came) {
  Verdict verdict = Compare(stamp_ns, came);
  if (verdict != Verdict::kTake) {
    astray_ = astray_ > 0 && stamp_ns > last_astray_ns_ ? astray_ + 1 : 1;
    last_astray_ns_ = stamp_ns;
    if (astray_ < kBeginAnew) return verdict;
    verdict = Verdict::kAnew;
  }
  newest_ = {stamp_ns, came};
  astray_ = 0;
  return verdict;
}

}  // namespace corbslam::client_agent
