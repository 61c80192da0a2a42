// Implements the part of MapStore that knows of missions whose journal is damaged.
#include <limits>

#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/store/map_store.h"
#include "map_store/view/damage_text.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kAll = std::numeric_limits<size_t>::max();

}  // namespace

MissionInfo MapStore::InfoOfUnreadable(const std::string& name, const absl::Status& damage) const {
  MissionInfo info;
  info.name = name;
  info.has_worker = has_worker();
  info.disk_bytes = journal_->DiskBytes(name);
  info.damage = SayDamage(name, damage);
  return info;
}

std::map<std::string, std::string> MapStore::ListDamaged() const {
  std::map<std::string, std::string> damaged;
  for (const KnownMission& known : directory_->List("", kAll)) {
    const absl::Status damage = known.damage.ok() ? journal_->Damage(known.name) : known.damage;
    if (!damage.ok()) damaged[known.name] = SayDamage(known.name, damage);
  }
  return damaged;
}

}  // namespace corbslam::map_store
