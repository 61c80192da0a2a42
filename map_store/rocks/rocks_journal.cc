#include "map_store/rocks/rocks_journal.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/batch_bytes.h"
#include "map_store/archive/record_archive.h"
#include "map_store/rocks/files_check.h"
#include "map_store/rocks/journal_scrubber.h"
#include "map_store/rocks/journal_tidier.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/mission_lists.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

RocksJournal::~RocksJournal() {
  if (tidier_ != nullptr) tidier_->Stop();
  if (scrubber_ != nullptr) scrubber_->Stop();
  for (const MissionPtr& mission : OpenMissions()) mission->Close();
  scrubber_.reset();
  tidier_.reset();
}

std::vector<RocksJournal::MissionPtr> RocksJournal::OpenMissions() const {
  std::vector<MissionPtr> missions;
  absl::MutexLock lock(&mutex_);
  for (const auto& [name, mission] : missions_) missions.push_back(mission);
  return missions;
}

absl::StatusOr<RocksJournal::MissionPtr> RocksJournal::FindMission(absl::string_view name) const {
  const std::string_view key(name.data(), name.size());
  absl::MutexLock lock(&mutex_);
  if (const auto it = unreadable_.find(key); it != unreadable_.end()) return it->second;
  const auto it = missions_.find(key);
  if (it != missions_.end()) return it->second;
  if (aside_.contains(key)) {
    return absl::UnavailableError(
        absl::StrCat("journal ", folder_.PathOf(name), ": it is closed, as nobody used it"));
  }
  return absl::NotFoundError(
      absl::StrCat("journal ", options_.directory, " has no mission ", name));
}

absl::Status RocksJournal::CheckRoomForRecord(uint64_t bytes) {
  const absl::Status room = CheckRoom(options_, bytes);
  record_without_room_ = room.ok() ? 0 : bytes;
  return room;
}

absl::Status RocksJournal::CheckWritable() {
  RETURN_IF_ERROR(CheckRoom(options_, record_without_room_));
  for (const MissionPtr& mission : OpenMissions()) {
    const absl::Status writable = mission->CheckWritable();
    // A damaged mission is that mission's trouble.
    if (mission->Damage().ok()) RETURN_IF_ERROR(writable);
  }
  return absl::OkStatus();
}

void RocksJournal::Prepare(BatchRecord& record) const { record.bytes = EncodeBatch(record); }

void RocksJournal::Prepare(AdjustRecord& record) const {
  record.plan_bytes = std::make_shared<const PlanBytes>(EncodePlan(record.plan));
}

absl::StatusOr<Journal::Position> RocksJournal::Append(absl::string_view mission,
                                                       const JournalRecord& record) {
  const std::shared_ptr<const BatchBytes> bytes = BytesOf(record);
  RETURN_IF_ERROR(CheckRoomForRecord(SizeOf(*bytes)));
  absl::StatusOr<MissionPtr> found = FindMission(mission);
  if (absl::IsNotFound(found.status())) found = MakeMission(mission);
  RETURN_IF_ERROR(found.status());
  return (*found)->Append(*bytes, RemovedBy(record));
}

absl::Status RocksJournal::Sync(absl::string_view mission, Position position) {
  const absl::StatusOr<MissionPtr> found = FindMission(mission);
  // A mission without any record, or one that was deleted, has nothing to sync.
  if (absl::IsNotFound(found.status())) return absl::OkStatus();
  RETURN_IF_ERROR(found.status());
  return (*found)->Sync(position);
}

bool RocksJournal::WantsSnapshot(absl::string_view mission) const {
  const absl::StatusOr<MissionPtr> found = FindMission(mission);
  return found.ok() && (*found)->Damage().ok() && (*found)->WantsSnapshot();
}

absl::Status RocksJournal::WriteSnapshot(absl::string_view mission,
                                         const JournalSnapshot& snapshot) {
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  RETURN_IF_ERROR(found->WriteSnapshot(snapshot));
  tidier_->Wake();
  return absl::OkStatus();
}

absl::Status RocksJournal::CreateMission(absl::string_view mission, const MissionState& state) {
  ASSIGN_OR_RETURN(const MissionPtr made, MakeMission(mission));
  const absl::Status status = made->Create(state);
  // Should removing it fail as well, the next start does it.
  if (!status.ok()) DeleteMission(mission).IgnoreError();
  return status;
}

absl::StatusOr<std::vector<std::string>> RocksJournal::ListMissions() const {
  std::vector<std::string> names;
  absl::MutexLock lock(&mutex_);
  for (const auto& [name, mission] : missions_) names.push_back(name);
  for (const auto& [name, status] : unreadable_) names.push_back(name);
  names.insert(names.end(), aside_.begin(), aside_.end());
  return names;
}

absl::Status RocksJournal::PutPicture(absl::string_view mission, const KeyframePicture& picture,
                                      uint64_t max_bytes) {
  // A picture makes no mission: it may have been deleted just now.
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  return found->PutPicture(picture, max_bytes);
}

absl::StatusOr<KeyframePicture> RocksJournal::ReadPicture(absl::string_view mission,
                                                          KeyframeId keyframe) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  return found->ReadPicture(keyframe);
}

absl::Status RocksJournal::ForEachPicture(
    absl::string_view mission,
    const std::function<absl::Status(const KeyframePicture& picture)>& visit) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  return found->ForEachPicture(visit);
}

absl::StatusOr<Journal::Position> RocksJournal::Recover(absl::string_view mission,
                                                        const Replay& replay) const {
  const absl::StatusOr<MissionPtr> found =
      IsAside(mission) ? BringBack(mission) : FindMission(mission);
  if (absl::IsNotFound(found.status())) return 0;
  RETURN_IF_ERROR(found.status());
  return (*found)->Recover(replay);
}

absl::Status RocksJournal::DeleteMission(absl::string_view mission) {
  absl::MutexLock making(&making_);
  const absl::StatusOr<MissionPtr> found = FindMission(mission);
  if (absl::IsNotFound(found.status())) return absl::OkStatus();
  // Nothing may write into the folder any more.
  if (found.ok()) (*found)->Close();
  RETURN_IF_ERROR(folder_.Remove(mission, kDeleted));
  RETURN_IF_ERROR(folder_.Turn(mission, kInUse, kDeleted));
  {
    absl::MutexLock lock(&mutex_);
    missions_.erase(std::string(mission));
    unreadable_.erase(std::string(mission));
    aside_.erase(std::string(mission));
    aside_damage_.erase(std::string(mission));
  }
  const absl::Status removed = folder_.Remove(mission, kDeleted);
  LOG_IF(WARNING, !removed.ok()) << "a deleted mission's files are left, until the next start: "
                                 << removed;
  return absl::OkStatus();
}

absl::Status RocksJournal::NoteInList(MissionList list, const MissionIdentity& mission) {
  absl::MutexLock making(&making_);
  return AddToMissionList(options_.directory, list, mission);
}

std::vector<MissionIdentity> RocksJournal::ReadList(MissionList list) const {
  return ReadMissionList(options_.directory, list);
}

absl::Status RocksJournal::Damage(absl::string_view mission) const {
  {
    absl::MutexLock lock(&mutex_);
    const auto it = aside_damage_.find(std::string_view(mission.data(), mission.size()));
    if (it != aside_damage_.end()) return it->second;
  }
  const absl::StatusOr<MissionPtr> found = FindMission(mission);
  if (found.ok()) return (*found)->Damage();
  return absl::IsDataLoss(found.status()) ? found.status() : absl::OkStatus();
}

uint64_t RocksJournal::DiskBytes(absl::string_view mission) const {
  return BytesIn(folder_.PathOf(mission));
}

absl::Status RocksJournal::Verify(absl::string_view mission) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  return found->Verify();
}

FilesCheck RocksJournal::CheckFiles(absl::string_view mission) const {
  return CheckClosedFiles(folder_.PathOf(mission));
}

absl::StatusOr<DatabaseMark> RocksJournal::Mark(absl::string_view mission) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  return found->Mark();
}

absl::Status RocksJournal::Lend(
    absl::string_view mission,
    const std::function<rocksdb::Status(rocksdb::DB& db, const std::function<bool()>& goes_on)>&
        use) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindMission(mission));
  return found->Lend(use);
}

ScrubCounts RocksJournal::scrub_counts() const {
  return scrubber_ != nullptr ? scrubber_->counts() : ScrubCounts();
}

void RocksJournal::ScrubNow() {
  if (scrubber_ != nullptr) scrubber_->RunRound([](uint64_t) { return true; });
}

}  // namespace corbslam::map_store
