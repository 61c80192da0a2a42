#include "client_agent/agent/hand_over.h"

namespace corbslam::client_agent {
namespace {

bool IsTrackedWell(const HandOverLimits& limits, const TrackingResult& result) {
  return result.points_matched >= limits.min_points_matched &&
         result.points_matched >= limits.min_share_matched * result.points_in_view;
}

}  // namespace

HandOverVerdict JudgeHandOver(const HandOverLimits& limits, const HandOverEvidence& evidence,
                              const TrackingResult& result) {
  const bool is_full = limits.max_map_bytes > 0 && evidence.map_bytes > limits.max_map_bytes;
  if (!is_full || evidence.own_keyframes < limits.min_own_keyframes) return HandOverVerdict::kFits;
  if (evidence.earlier_map_waits || !evidence.outbox_has_room) return HandOverVerdict::kLinkIsLate;
  if (result.state != TrackingState::kTracking) return HandOverVerdict::kMomentIsBad;
  const bool is_overdue = static_cast<double>(evidence.map_bytes) >
                          limits.overdue * static_cast<double>(limits.max_map_bytes);
  const bool is_good = evidence.mapping_idle && IsTrackedWell(limits, result);
  return is_good || is_overdue ? HandOverVerdict::kNow : HandOverVerdict::kMomentIsBad;
}

}  // namespace corbslam::client_agent
