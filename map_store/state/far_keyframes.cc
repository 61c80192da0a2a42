#include "map_store/state/far_keyframes.h"

namespace corbslam::map_store {
namespace {

// Sums of metres are rounded: so much of the way more counts as travelled.
constexpr double kRounding = 1e-9;

}  // namespace

void FarKeyframes::MoveTo(const Eigen::Vector3d& robot) {
  if (robot_.has_value()) travelled_m_ += (robot - *robot_).norm();
  robot_ = robot;
}

void FarKeyframes::Add(KeyframeId id, double out_of_reach_m) {
  Erase(id);
  const double due_at_m = travelled_m_ + out_of_reach_m;
  due_at_m_[id] = due_at_m;
  by_due_.insert({due_at_m, id});
}

void FarKeyframes::Erase(KeyframeId id) {
  const auto it = due_at_m_.find(id);
  if (it == due_at_m_.end()) return;
  by_due_.erase({it->second, id});
  due_at_m_.erase(it);
}

std::vector<KeyframeId> FarKeyframes::TakeDue() {
  std::vector<KeyframeId> due;
  const double travelled_m = travelled_m_ * (1 + kRounding) + kRounding;
  auto it = by_due_.begin();
  for (; it != by_due_.end() && it->first <= travelled_m; ++it) {
    due.push_back(it->second);
    due_at_m_.erase(it->second);
  }
  by_due_.erase(by_due_.begin(), it);
  return due;
}

std::vector<KeyframeId> FarKeyframes::TakeAll() {
  std::vector<KeyframeId> all;
  for (const auto& [id, due] : due_at_m_) all.push_back(id);
  due_at_m_.clear();
  by_due_.clear();
  return all;
}

}  // namespace corbslam::map_store
