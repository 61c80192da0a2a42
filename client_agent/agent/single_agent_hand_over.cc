// How SingleAgent keeps its map within AgentOptions::max_map_bytes.
#include <glog/logging.h>

#include <utility>

#include "client_agent/agent/single_agent.h"

namespace corbslam::client_agent {

HandOverEvidence SingleAgent::GatherEvidence() const {
  HandOverEvidence evidence;
  evidence.map_bytes = current().map_bytes();
  // The rest is of interest for a full map only.
  if (evidence.map_bytes <= max_map_bytes_) return evidence;
  evidence.own_keyframes = current().map().own_items().keyframes;
  evidence.outbox_has_room = link_->upload().room.ok();
  evidence.mapping_idle = current().IsIdle();
  absl::MutexLock lock(&mutex_);
  evidence.earlier_map_waits = sessions_.size() > 1;
  return evidence;
}

void SingleAgent::HandOverIfFull(const TrackingResult& result) {
  if (max_map_bytes_ == 0) return;
  if (ShedOthers(result, current().map_bytes())) return;
  const HandOverLimits limits = {.max_map_bytes = max_map_bytes_};
  const HandOverEvidence evidence = GatherEvidence();
  const HandOverVerdict verdict = JudgeHandOver(limits, evidence, result);
  if (verdict == HandOverVerdict::kLinkIsLate) WarnOfLateLink(evidence.map_bytes);
  if (verdict != HandOverVerdict::kNow) return;
  const std::optional<HandedFrame> handed = current().tracker().HandOver();
  if (!handed.has_value()) return current().tracker().SearchNext();
  LOG(INFO) << "the local map takes " << (evidence.map_bytes >> 20) << " MiB of "
            << (max_map_bytes_ >> 20) << " that it may: the robot goes on in a new one";
  HandOver(*handed);
}

bool SingleAgent::ShedOthers(const TrackingResult& result, uint64_t map_bytes) {
  // What comes back from the spool is bounded as it is.
  if (far_ != nullptr || options_.share.mode != ShareMode::kNearby) return false;
  if (result.state != TrackingState::kTracking) return false;
  SheddingEvidence evidence;
  evidence.map_bytes = map_bytes;
  evidence.own_keyframes = static_cast<size_t>(current().map().own_items().keyframes);
  evidence.foreign_keyframes = link_->shared_keyframes();
  evidence.centre = CameraCentre(result.camera_from_local);
  evidence.timestamp_ns = result.timestamp_ns;
  const std::optional<double> radius_m = shedder_.Judge(evidence);
  if (!radius_m.has_value()) return shedder_.IsUnderWay(result.timestamp_ns);
  LOG(INFO) << "others' " << evidence.foreign_keyframes
            << " keyframes take most of the local map's " << (map_bytes >> 20)
            << " MiB: those farther than " << *radius_m << " m go";
  link_->AskAnew(*radius_m);
  return true;
}

void SingleAgent::HandOver(const HandedFrame& handed) {
  EndLocalMap();
  OpenLocalMap(GlobalFromLocal(), /*spooled_map=*/nullptr, /*goes_on=*/true);
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
      << "the local map takes " << (map_bytes >> 20) << " MiB of " << (max_map_bytes_ >> 20)
      << " that it may, and nothing of it can leave memory before the map store or a spool "
         "takes what waits: the robot's memory grows until then";
}

}  // namespace corbslam::client_agent
