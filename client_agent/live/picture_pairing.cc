#include "client_agent/live/picture_pairing.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace corbslam::client_agent {
namespace {

// So many pictures of one side wait for the other side's: a side that has stopped takes no memory.
constexpr size_t kMostWaiting = 8;

}  // namespace

void PicturePairing::Push(LiveSide side, LivePicture picture) {
  const auto index = static_cast<size_t>(side);
  if (side == LiveSide::kSecond) picture.timestamp_ns += second_offset_ns_;
  const absl::MutexLock lock(&mutex_);
  ++counts_.pictures[index];
  if (!Takes(side, picture.timestamp_ns)) return;
  if (!both_) return Publish(std::move(picture), {});
  waiting_[index].push_back(std::move(picture));
  PairUp();
  if (waiting_[index].size() <= kMostWaiting) return;
  waiting_[index].pop_front();
  ++counts_.unpaired;
}

bool PicturePairing::Takes(LiveSide side, int64_t timestamp_ns) {
  switch (
      stamps_[static_cast<size_t>(side)].Judge(timestamp_ns, std::chrono::steady_clock::now())) {
    case StampWatch::Verdict::kTake:
      return true;
    case StampWatch::Verdict::kLate:
      ++counts_.late;
      return false;
    case StampWatch::Verdict::kAhead:
      ++counts_.ahead;
      return false;
    case StampWatch::Verdict::kAnew:
      break;
  }
  ++drive_;
  // What waits for a counterpart is of the clock before, and so may the other side's next one be.
  for (std::deque<LivePicture>& waiting : waiting_) {
    counts_.unpaired += waiting.size();
    waiting.clear();
  }
  stamps_[1 - static_cast<size_t>(side)].Reset();
  return true;
}

void PicturePairing::PairUp() {
  auto& [first, second] = waiting_;
  while (!first.empty() && !second.empty()) {
    const int64_t apart_ns = second.front().timestamp_ns - first.front().timestamp_ns;
    if (apart_ns > within_ns_) {
      DropUnpaired(first, apart_ns);
    } else if (apart_ns < -within_ns_) {
      DropUnpaired(second, -apart_ns);
    } else {
      apart_sum_ns_ += apart_ns;
      counts_.most_apart_ns = std::max(counts_.most_apart_ns, std::abs(apart_ns));
      Publish(std::move(first.front()), std::move(second.front()));
      first.pop_front();
      second.pop_front();
    }
  }
}

void PicturePairing::DropUnpaired(std::deque<LivePicture>& waiting, int64_t apart_ns) {
  waiting.pop_front();
  ++counts_.unpaired;
  int64_t& nearest_ns = counts_.nearest_unpaired_ns;
  nearest_ns = nearest_ns == 0 ? apart_ns : std::min(nearest_ns, apart_ns);
}

void PicturePairing::Publish(LivePicture first, LivePicture second) {
  if (newest_.has_value()) ++counts_.overtaken;
  newest_ = LivePair{counts_.frames++, drive_, std::move(first), std::move(second),
                     std::chrono::steady_clock::now()};
}

void PicturePairing::End(absl::Status status) {
  const absl::MutexLock lock(&mutex_);
  if (!ended_.has_value()) ended_ = std::move(status);
}

absl::StatusOr<std::optional<LivePair>> PicturePairing::Take(absl::Time deadline) {
  const absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithDeadline(absl::Condition(this, &PicturePairing::IsAnswerable), deadline);
  if (newest_.has_value()) return std::exchange(newest_, std::nullopt);
  if (!ended_.has_value()) return std::nullopt;
  return ended_->ok() ? absl::OutOfRangeError("the camera gives no more frames") : *ended_;
}

CameraCounts PicturePairing::counts() const {
  const absl::MutexLock lock(&mutex_);
  CameraCounts counts = counts_;
  if (counts.frames > 0) counts.mean_apart_ns = apart_sum_ns_ / static_cast<int64_t>(counts.frames);
  return counts;
}

}  // namespace corbslam::client_agent
