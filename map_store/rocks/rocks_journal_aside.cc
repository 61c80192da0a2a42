// Implements the part of RocksJournal that keeps missions without having them open.
#include <glog/logging.h>

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/files_check.h"
#include "map_store/rocks/journal_scrubber.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/rocks_database.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/rocks/summary_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

bool RocksJournal::IsAside(absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  return aside_.contains(std::string_view(name.data(), name.size()));
}

void RocksJournal::TidyUp(absl::string_view mission) {
  const absl::StatusOr<MissionPtr> found = FindMission(mission);
  if (!found.ok()) return;
  const absl::Status settled = (*found)->Settle();
  LOG_IF(WARNING, !settled.ok()) << "a mission lies aside as it is: " << settled;
}

absl::Status RocksJournal::PutAside(absl::string_view mission, absl::string_view summary) {
  const std::string name(mission);
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(name));
  found->Close();
  {
    absl::MutexLock lock(&mutex_);
    missions_.erase(name);
    aside_.insert(name);
  }
  return WriteSummaryFile(folder_.PathOf(name), summary);
}

absl::StatusOr<std::string> RocksJournal::ReadSummary(absl::string_view mission) const {
  if (!IsAside(mission)) {
    return absl::NotFoundError(absl::StrCat("mission ", mission, " does not lie aside"));
  }
  return ReadSummaryFile(folder_.PathOf(mission));
}

absl::StatusOr<RocksJournal::MissionPtr> RocksJournal::BringBack(absl::string_view mission) const {
  const std::string name(mission);
  RemoveSummaryFile(folder_.PathOf(name));
  absl::StatusOr<MissionPtr> opened = OpenMission(name);
  if (opened.ok()) {
    const absl::Status loaded = (*opened)->Load();
    // It was whole when it was put aside.
    if (absl::IsNotFound(loaded)) opened = absl::DataLossError(loaded.message());
    if (!loaded.ok() && opened.ok()) opened = loaded;
  }
  if (!opened.ok() && !absl::IsDataLoss(opened.status())) return opened.status();
  const absl::Status damage = NameDamagedFiles(folder_.PathOf(name), opened.status());
  absl::MutexLock lock(&mutex_);
  aside_.erase(name);
  aside_damage_.erase(name);
  if (!damage.ok()) return unreadable_[name] = damage;
  return missions_[name] = *std::move(opened);
}

void RocksJournal::StartScrubber() {
  JournalScrubber::Access access;
  access.list_open = [this] { return OpenMissions(); };
  access.list_closed = [this] {
    absl::MutexLock lock(&mutex_);
    return std::vector<std::string>(aside_.begin(), aside_.end());
  };
  access.open_closed = [this](const std::string& name, const ReadPace& pace) {
    return OpenAside(name, pace);
  };
  access.is_closed = [this](const std::string& name) { return IsAside(name); };
  access.note_closed = [this](const std::string& name, const absl::Status& damage) {
    return NoteAside(name, damage);
  };
  scrubber_ = std::make_unique<JournalScrubber>(std::move(access), options_.scrub_bytes_per_s);
}

absl::StatusOr<RocksJournal::MissionPtr> RocksJournal::OpenAside(
    const std::string& name, const std::function<bool(uint64_t bytes)>& pace) {
  const std::string path = folder_.PathOf(name);
  {
    absl::MutexLock lock(&mutex_);
    if (!aside_.contains(name) || aside_damage_.contains(name)) return MissionPtr();
    aside_lists_[name] = ReadCurrentFile(path);
  }
  const FilesCheck files = CheckClosedFiles(path, pace);
  for (const std::string& note : files.notes) LOG(WARNING) << "mission " << name << ": " << note;
  RETURN_IF_ERROR(files.status());
  RocksJournalOptions options = options_;
  options.only_read = true;
  auto database = std::make_unique<RocksDatabase>(path, options_.env, cache_);
  const rocksdb::Status opened = database->Open(RocksDatabase::Mode::kOnlyRead);
  if (!opened.ok()) return NameDamagedFiles(path, OpenFailure(path, opened));
  auto mission = std::make_shared<MissionJournal>(name, options, std::move(database));
  const absl::Status loaded = mission->LoadRecordsOnly();
  // It was whole when it was put aside.
  if (absl::IsNotFound(loaded)) return absl::DataLossError(loaded.message());
  RETURN_IF_ERROR(NameDamagedFiles(path, loaded));
  return mission;
}

bool RocksJournal::NoteAside(const std::string& name, const absl::Status& damage) {
  const std::string current = ReadCurrentFile(folder_.PathOf(name));
  absl::MutexLock lock(&mutex_);
  // Whoever opens it begins another list of files.
  if (!aside_.contains(name) || aside_lists_[name] != current) return false;
  aside_damage_[name] = damage;
  return true;
}

}  // namespace corbslam::map_store
