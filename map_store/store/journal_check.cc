#include "map_store/store/journal_check.h"

#include <memory>
#include <vector>

#include "absl/time/clock.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/rocks/files_check.h"
#include "map_store/rocks/rocks_journal.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Reads the mission as a store does, but for words, which decide nothing here.
absl::Status ReadMission(RocksJournal& journal, CheckedMission& mission) {
  const FilesCheck files = journal.CheckFiles(mission.name);
  mission.notes = files.notes;
  mission.notes.insert(mission.notes.end(), files.torn.begin(), files.torn.end());
  RETURN_IF_ERROR(journal.Verify(mission.name));
  RETURN_IF_ERROR(files.status());
  const MapStoreOptions options;
  MissionEnvironment environment;
  environment.options = &options;
  environment.journal = &journal;
  environment.clock = &absl::Now;
  environment.wake_fusion = [] {};
  MissionStrand strand(mission.name, std::move(environment));
  RETURN_IF_ERROR(strand.Recover());
  strand.WithState([&mission](const MissionState& state) {
    mission.agents = state.agents.size();
    mission.local_maps = state.local_maps.size();
    for (const auto& [id, local_map] : state.local_maps) {
      mission.keyframes += local_map.map.keyframes().size();
    }
    return 0;
  });
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckJournal(const std::string& directory,
                          const std::function<void(const CheckedMission&)>& tell) {
  RocksJournalOptions options;
  options.directory = directory;
  options.only_read = true;
  ASSIGN_OR_RETURN(const std::unique_ptr<RocksJournal> journal, RocksJournal::Open(options));
  ASSIGN_OR_RETURN(const std::vector<std::string> names, journal->ListMissions());
  for (const std::string& name : names) {
    CheckedMission mission;
    mission.name = name;
    mission.disk_bytes = journal->DiskBytes(name);
    mission.status = ReadMission(*journal, mission);
    tell(mission);
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
