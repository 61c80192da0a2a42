// Implements the part of MapStore that knows of missions whose journal is damaged.
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/map_store.h"
#include "map_store/mission/mission.h"
#include "map_store/view/damage_words.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Status MapStore::CheckReadable(absl::string_view name) const {
  const auto it = unreadable_.find(std::string(name));
  if (it == unreadable_.end()) return absl::OkStatus();
  return absl::DataLossError(SayDamage(name, it->second));
}

MissionInfo MapStore::InfoOfUnreadable(const std::string& name, const absl::Status& damage) const {
  MissionInfo info;
  info.name = name;
  info.has_worker = has_worker();
  info.disk_bytes = journal_->DiskBytes(name);
  info.damage = SayDamage(name, damage);
  return info;
}

std::optional<MissionInfo> MapStore::DescribeUnreadable(absl::string_view name) const {
  absl::Status damage;
  {
    absl::MutexLock lock(&mutex_);
    const auto it = unreadable_.find(std::string(name));
    if (it == unreadable_.end()) return std::nullopt;
    damage = it->second;
  }
  return InfoOfUnreadable(std::string(name), damage);
}

absl::StatusOr<bool> MapStore::DeleteUnreadable(absl::string_view name) {
  {
    absl::MutexLock lock(&mutex_);
    if (!unreadable_.contains(std::string(name))) return false;
  }
  RETURN_IF_ERROR(journal_->DeleteMission(name));
  absl::MutexLock lock(&mutex_);
  unreadable_.erase(std::string(name));
  return true;
}

std::map<std::string, std::string> MapStore::ListDamaged() const {
  std::map<std::string, std::string> damaged;
  std::vector<std::string> readable;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [name, damage] : unreadable_) damaged[name] = SayDamage(name, damage);
    for (const auto& [name, mission] : missions_) readable.push_back(name);
  }
  for (const std::string& name : readable) {
    const absl::Status damage = journal_->Damage(name);
    if (!damage.ok()) damaged[name] = SayDamage(name, damage);
  }
  return damaged;
}

}  // namespace corbslam::map_store
