// Implements the part of MapStore that knows of missions on the disk alone.
#include <limits>
#include <utility>

#include "map_store/map_store.h"
#include "map_store/mission/mission.h"
#include "map_store/mission/mission_directory.h"
#include "map_store/mission/mission_load.h"
#include "map_store/view/damage_words.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

MissionInfo MapStore::Describe(const KnownMission& known) const {
  if (!known.damage.ok()) return InfoOfUnreadable(known.name, known.damage);
  MissionInfo info;
  if (known.mission != nullptr) {
    info = known.mission->Info();
    info.disk_bytes = journal_->DiskBytes(info.name);
  } else {
    info = known.sleeper->summary.info;
    info.asleep = true;
  }
  info.last_used_ns = absl::ToUnixNanos(known.last_used);
  info.has_worker = has_worker();
  info.worker_outage = worker_outage();
  info.damage = SayDamage(info.name, journal_->Damage(info.name));
  return info;
}

std::vector<MissionLoad> MapStore::ListLoads() const {
  std::vector<MissionLoad> loads;
  for (const KnownMission& known : directory_->List("", std::numeric_limits<size_t>::max())) {
    if (known.mission != nullptr) loads.push_back(known.mission->Load());
    if (known.sleeper != nullptr) loads.push_back(known.sleeper->summary.load);
  }
  return loads;
}

absl::StatusOr<std::shared_ptr<Mission>> MapStore::LoadSleeper(const std::string& name,
                                                               const Sleeper& sleeper) {
  std::shared_ptr<Mission> mission = MakeMission(name);
  RETURN_IF_ERROR(mission->Recover());
  mission->events().GoOnFrom(sleeper.events);
  Wake();
  return mission;
}

}  // namespace corbslam::map_store
