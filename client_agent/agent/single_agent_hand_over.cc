// How SingleAgent keeps its map within AgentOptions::max_map_bytes.
#include <glog/logging.h>

#include <utility>

#include "client_agent/agent/single_agent.h"

namespace corbslam::client_agent {

HandOverEvidence SingleAgent::GatherEvidence() const {
  HandOverEvidence evidence;
  evidence.map_bytes = current().map_bytes();
  // The rest is of interest for a full map only.
  if (evidence.map_bytes <= options_.max_map_bytes) return evidence;
  evidence.own_keyframes = current().map().own_items().keyframes;
  evidence.outbox_has_room = link_->upload().room.ok();
  evidence.mapping_idle = current().IsIdle();
  absl::MutexLock lock(&mutex_);
  evidence.earlier_map_waits = sessions_.size() > 1;
  return evidence;
}

void SingleAgent::HandOverIfFull(const TrackingResult& result) {
  if (options_.max_map_bytes == 0) return;
  const HandOverLimits limits = {.max_map_bytes = options_.max_map_bytes};
  const HandOverEvidence evidence = GatherEvidence();
  const HandOverVerdict verdict = JudgeHandOver(limits, evidence, result);
  if (verdict == HandOverVerdict::kLinkIsLate) WarnOfLateLink(evidence.map_bytes);
  if (verdict != HandOverVerdict::kNow) return;
  const std::optional<HandedFrame> handed = current().tracker().HandOver();
  if (!handed.has_value()) return;
  LOG(INFO) << "the local map takes " << (evidence.map_bytes >> 20) << " MiB of "
            << (options_.max_map_bytes >> 20) << " that it may: the robot goes on in a new one";
  HandOver(*handed);
}

void SingleAgent::HandOver(const HandedFrame& handed) {
  EndLocalMap();
  OpenLocalMap(GlobalFromLocal(), /*kept=*/nullptr, /*goes_on=*/true);
  warned_of_late_link_ = false;
  // The queue of a new local map has room.
  CHECK(current().tracker().TakeOver(handed));
  smooth_pose_.GoOnIn(current().map().local_map());
  absl::MutexLock lock(&mutex_);
  ++status_.hand_overs;
}

void SingleAgent::WarnOfLateLink(uint64_t map_bytes) {
  if (std::exchange(warned_of_late_link_, true)) return;
  LOG(WARNING)
      << "the local map takes " << (map_bytes >> 20) << " MiB of " << (options_.max_map_bytes >> 20)
      << " that it may, and nothing of it can leave memory before the map store or a spool "
         "takes what waits: the robot's memory grows until then";
}

}  // namespace corbslam::client_agent
