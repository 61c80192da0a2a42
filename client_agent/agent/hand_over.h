// Decides when a robot whose memory is bounded goes on in a new local map (docs/robot.md).
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_HAND_OVER_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_HAND_OVER_H_

#include <cstdint>

#include "client_agent/tracking/tracking_result.h"

namespace corbslam::client_agent {

struct HandOverLimits {
  // Bytes that the local map in use may take.
  uint64_t max_map_bytes = 0;
  // A local map of fewer own keyframes goes on: where others' fill it, the next one would soon be
  // as full, and the map store would find no way to join what is so short.
  int min_own_keyframes = 10;
  // A frame that is handed over must agree with so many points, and with this share of those in
  // view: twice what tracking asks for at least.
  int min_points_matched = 60;
  double min_share_matched = 0.3;
  // With so many times the bytes, any tracked frame will do, and mapping is waited for.
  double overdue = 1.1;
};

// The evidence that the decision rests on.
struct HandOverEvidence {
  uint64_t map_bytes = 0;
  int own_keyframes = 0;
  // True: an earlier local map is in memory yet, because the link has not told all of it.
  bool earlier_map_waits = false;
  // False: neither memory nor disk takes more batches, so that the map could not leave either.
  bool outbox_has_room = true;
  // True: neither mapping nor loop closing has work.
  bool mapping_idle = true;
};

enum class HandOverVerdict {
  kFits,         // The map is within its bounds, or too small to be left.
  kLinkIsLate,   // Nothing would leave memory now.
  kMomentIsBad,  // A later frame will do better.
  kNow,
};

// Judges whether the frame of `result` is to end the local map in use. Pure.
HandOverVerdict JudgeHandOver(const HandOverLimits& limits, const HandOverEvidence& evidence,
                              const TrackingResult& result);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_HAND_OVER_H_
