// Implements the part of RocksJournal that keeps missions without having them open.
#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
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
  absl::MutexLock lock(&mutex_);
  aside_.erase(name);
  if (!opened.ok()) return unreadable_[name] = opened.status();
  return missions_[name] = *std::move(opened);
}

}  // namespace corbslam::map_store
