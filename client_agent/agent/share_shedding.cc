#include "client_agent/agent/share_shedding.h"

#include <algorithm>

namespace corbslam::client_agent {
namespace {

// What was asked for is here by then, or does not come.
constexpr int64_t kUnderWay_ns = 5'000'000'000;
constexpr double kShrinks = 1.5;
constexpr double kGrows = 1.25;

}  // namespace

std::optional<double> ShareShedder::Judge(const SheddingEvidence& evidence) {
  if (limits_.max_map_bytes == 0 || evidence.foreign_keyframes == 0) return std::nullopt;
  const double share = static_cast<double>(evidence.foreign_keyframes) /
                       static_cast<double>(evidence.foreign_keyframes + evidence.own_keyframes);
  const double foreign_bytes = share * static_cast<double>(evidence.map_bytes);
  if (foreign_bytes <= limits_.max_share * static_cast<double>(limits_.max_map_bytes)) {
    return std::nullopt;
  }
  if (asked_.has_value()) {
    if (IsUnderWay(evidence.timestamp_ns)) return std::nullopt;
    const bool goes_on = (evidence.centre - asked_->centre).norm() >= radius_m_ / 2;
    if (!goes_on && radius_m_ <= limits_.min_radius_m) return std::nullopt;
    radius_m_ = goes_on ? std::min(radius_m_ * kGrows, limits_.radius_m)
                        : std::max(radius_m_ / kShrinks, limits_.min_radius_m);
  }
  asked_ = Asked{evidence.centre, evidence.timestamp_ns};
  return radius_m_;
}

bool ShareShedder::IsUnderWay(int64_t timestamp_ns) const {
  return asked_.has_value() && timestamp_ns - asked_->timestamp_ns < kUnderWay_ns;
}

}  // namespace corbslam::client_agent
