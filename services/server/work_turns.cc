#include "services/server/work_turns.h"

#include <algorithm>
#include <utility>

namespace corbslam::services {
namespace {

// More missions than that which ask for nothing now are forgotten.
constexpr size_t kMostIdle = 10000;

}  // namespace

void WorkTurns::Add(Request request, absl::Time now) {
  ++missions_[request.mission].waiting;
  waiting_.push_back({std::move(request), now});
}

bool WorkTurns::GoesBefore(const Waiting& a, const Waiting& b, absl::Time now) const {
  const auto stands_back = [this, now](const Waiting& one) {
    return one.request.may_wait && (now - one.since < kPatience || others_begun_ < kOthersBetween);
  };
  if (stands_back(a) != stands_back(b)) return stands_back(b);
  const Mission& of_a = missions_.at(a.request.mission);
  const Mission& of_b = missions_.at(b.request.mission);
  if (of_a.running != of_b.running) return of_a.running < of_b.running;
  return of_a.last_turn < of_b.last_turn;
}

WorkTurns::Request WorkTurns::Begin(absl::Time now) {
  // Of equals the first stays, which came first.
  const auto next = std::min_element(
      waiting_.begin(), waiting_.end(),
      [this, now](const Waiting& a, const Waiting& b) { return GoesBefore(a, b, now); });
  Request request = std::move(next->request);
  waiting_.erase(next);
  Mission& mission = missions_[request.mission];
  --mission.waiting;
  ++mission.running;
  mission.last_turn = ++turns_;
  others_begun_ = request.may_wait ? 0 : others_begun_ + 1;
  return request;
}

void WorkTurns::End(const std::string& mission) {
  const auto it = missions_.find(mission);
  if (it == missions_.end()) return;
  --it->second.running;
  if (missions_.size() > kMostIdle) ForgetIfIdle(mission);
}

void WorkTurns::ForgetIfIdle(const std::string& mission) {
  const auto it = missions_.find(mission);
  if (it->second.running == 0 && it->second.waiting == 0) missions_.erase(it);
}

}  // namespace corbslam::services
