#include "map_store/rocks/journal_rehearsal.h"

#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/folder_lock.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/journal_upgrade.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_database.h"
#include "map_store/rocks/rocks_journal.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Returns the folder's format, 0 where there is none.
absl::StatusOr<uint32_t> ReadFormat(const RocksDatabase& guard) {
  std::string bytes;
  const rocksdb::Status found = guard.Get(map_store::FormatKey(), &bytes);
  if (found.IsNotFound()) return 0;
  if (!found.ok()) return absl::DataLossError(found.ToString());
  std::string program;
  if (!guard.Get(map_store::ProgramKey(), &program).ok()) program.clear();
  return CheckFormat(bytes, program);
}

absl::StatusOr<MissionToUpgrade> Measure(const RocksDatabase& shared, const std::string& name) {
  MissionToUpgrade mission;
  mission.name = name;
  for (const JournalPart part : {JournalPart::kMission, JournalPart::kRecord,
                                 JournalPart::kSnapshot, JournalPart::kFeatures}) {
    const std::string prefix = MissionPrefix(part, name);
    const absl::Status scanned =
        shared.Scan(prefix, EndOfPrefix(prefix), [&](std::string_view key, std::string_view value) {
          mission.records += part == JournalPart::kRecord ? 1 : 0;
          mission.keyframes += part == JournalPart::kFeatures ? 1 : 0;
          mission.bytes += key.size() + value.size();
          return absl::OkStatus();
        });
    if (scanned.ok()) continue;
    return absl::Status(scanned.code(), absl::StrCat("mission ", name, ": ", scanned.message()));
  }
  return mission;
}

absl::Status InFolder(const std::string& directory, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat("journal ", directory, ": ", status.message()));
}

// Each mission has a database of its own already, which becomes the new one where it is.
absl::StatusOr<UpgradePlan> PlanInPlace(const std::string& directory, UpgradePlan plan) {
  const JournalFolder folder(directory);
  ASSIGN_OR_RETURN(const std::vector<std::string> names, folder.ListKept());
  for (const std::string& name : names) {
    RocksDatabase own(folder.PathOf(name), nullptr, MakeBlockCache());
    const rocksdb::Status opened = own.Open(RocksDatabase::Mode::kOnlyRead);
    if (!opened.ok()) return InFolder(folder.PathOf(name), absl::DataLossError(opened.ToString()));
    const absl::StatusOr<MissionToUpgrade> mission = Measure(own, name);
    if (!mission.ok()) return InFolder(directory, mission.status());
    plan.missions.push_back(*mission);
  }
  return plan;
}

}  // namespace

absl::StatusOr<UpgradePlan> PlanUpgrade(const std::string& directory) {
  ASSIGN_OR_RETURN(const std::unique_ptr<FolderLock> lock, FolderLock::Take(directory));
  UpgradePlan plan;
  plan.to = kJournalFormat;
  std::error_code error;
  if (!std::filesystem::exists(directory + "/CURRENT", error)) {
    // Once there is a folder of missions, the guard has nothing that could be lost.
    plan.from = JournalFolder(directory).exists() ? kJournalFormat : 0;
    return plan;
  }
  RocksDatabase guard(directory, nullptr, MakeBlockCache());
  const rocksdb::Status opened = guard.Open(RocksDatabase::Mode::kOnlyRead);
  if (!opened.ok()) return InFolder(directory, absl::DataLossError(opened.ToString()));
  const absl::StatusOr<uint32_t> format = ReadFormat(guard);
  if (!format.ok()) return InFolder(directory, format.status());
  plan.from = *format;
  if (JournalFolder(directory).exists() && plan.from <= kLastSharedFormat) plan.from = plan.to;
  const auto space = std::filesystem::space(directory, error);
  plan.bytes_free = error ? 0 : space.available;
  if (!plan.needed()) return plan;
  if (JournalFolder(directory).exists()) return PlanInPlace(directory, std::move(plan));
  plan.bytes_needed = BytesIn(directory);
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ListSharedMissions(guard));
  for (const std::string& name : names) {
    const absl::StatusOr<MissionToUpgrade> mission = Measure(guard, name);
    if (!mission.ok()) return InFolder(directory, mission.status());
    plan.missions.push_back(*mission);
  }
  return plan;
}

absl::Status UpgradeFolder(const std::string& directory) {
  RocksJournalOptions options;
  options.directory = directory;
  return RocksJournal::Open(options).status();
}

}  // namespace corbslam::map_store
