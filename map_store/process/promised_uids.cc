#include "map_store/process/promised_uids.h"

#include "slam/util/status_macros.h"

namespace corbslam::map_store {

void PromisedUids::Recover() {
  absl::MutexLock lock(&mutex_);
  for (const MissionIdentity& mission : journal_.ReadList(MissionList::kPromised)) Keep(mission);
}

absl::Status PromisedUids::Promise(const MissionIdentity& mission) {
  // A robot that comes meanwhile waits here: it, too, may be told only what is durable.
  absl::MutexLock writing(&writing_);
  if (Find(mission.name) == mission.uid) return absl::OkStatus();
  RETURN_IF_ERROR(journal_.NoteInList(MissionList::kPromised, mission));
  absl::MutexLock lock(&mutex_);
  Keep(mission);
  return absl::OkStatus();
}

std::string PromisedUids::Find(const std::string& name) const {
  absl::MutexLock lock(&mutex_);
  const auto it = uids_.find(name);
  return it == uids_.end() ? "" : it->second;
}

void PromisedUids::Keep(const MissionIdentity& mission) {
  uids_[mission.name] = mission.uid;
  in_order_.push_back(mission);
  if (in_order_.size() <= Journal::kMaxListed) return;
  const MissionIdentity& oldest = in_order_.front();
  const auto it = uids_.find(oldest.name);
  if (it != uids_.end() && it->second == oldest.uid) uids_.erase(it);
  in_order_.pop_front();
}

}  // namespace corbslam::map_store
