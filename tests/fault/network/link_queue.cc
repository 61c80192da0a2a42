#include "tests/fault/network/link_queue.h"

#include <algorithm>
#include <utility>

namespace corbslam::tests {

bool LinkQueue::IsLost(absl::Time now, size_t bytes) {
  if (!shape_.IsUp(now - start_)) return true;
  if (std::uniform_real_distribution<double>(0, 1)(random_) < shape_.loss) return true;
  if (shape_.rate <= 0) return false;
  const double waiting = absl::ToDoubleSeconds(free_ - now) * shape_.rate / 8;
  return waiting + static_cast<double>(bytes) > static_cast<double>(shape_.max_waiting_bytes);
}

void LinkQueue::Push(std::string packet, absl::Time now) {
  if (IsLost(now, packet.size())) {
    ++counts_.lost;
    return;
  }
  free_ = std::max(free_, now);
  if (shape_.rate > 0) {
    free_ += absl::Seconds(static_cast<double>(packet.size()) * 8 / shape_.rate);
  }
  packets_.push_back({free_ + shape_.delay, std::move(packet)});
}

std::optional<std::string> LinkQueue::Pop(absl::Time now) {
  while (!packets_.empty() && packets_.front().due <= now) {
    Packet packet = std::move(packets_.front());
    packets_.pop_front();
    // A packet that was on its way when the link went is gone too.
    if (!shape_.IsUp(packet.due - start_)) {
      ++counts_.lost;
      continue;
    }
    ++counts_.passed;
    return std::move(packet.bytes);
  }
  return std::nullopt;
}

absl::Time LinkQueue::NextDue() const {
  return packets_.empty() ? absl::InfiniteFuture() : packets_.front().due;
}

}  // namespace corbslam::tests
