// Implements the part of BackupFolder that compares files with their checksums.
#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/rocks/backup_folder.h"
#include "map_store/rocks/journal_folder.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;

constexpr char kWhatToDo[] =
    ". Restore another one; what the mission still has of it is copied anew with its next backup";

// Backup files are named after those of the database: its number, then more.
std::string LiveName(const SummedFile& file) {
  const fs::path path(file.name);
  const std::string name = path.filename().string();
  return name.substr(0, name.find('_')) + path.extension().string();
}

std::vector<uint32_t> ReadNumbers(const std::string& folder) {
  std::vector<uint32_t> numbers;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder + "/meta", error)) {
    uint32_t number = 0;
    if (absl::SimpleAtoi(entry.path().filename().string(), &number)) numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

void BackupFolder::LoadHealth() {
  const absl::StatusOr<std::vector<std::string>> missions = ListMissions();
  absl::MutexLock lock(&health_mutex_);
  for (const std::string& mission : missions.value_or(std::vector<std::string>())) {
    const HealthByNumber known = ReadBackupHealth(FolderOf(mission));
    for (const uint32_t number : ReadNumbers(FolderOf(mission))) {
      const auto it = known.find(number);
      health_[mission][number] = it == known.end() ? BackupHealth() : it->second;
    }
  }
}

ShelfHealth BackupFolder::health() const {
  ShelfHealth all;
  absl::Time oldest = absl::InfiniteFuture();
  absl::MutexLock lock(&health_mutex_);
  for (const auto& [mission, backups] : health_) {
    for (const auto& [number, health] : backups) {
      all.damaged += health.damage.empty() ? 0 : 1;
      const bool is_new = health.verified == absl::InfinitePast();
      all.unverified += is_new && health.damage.empty() ? 1 : 0;
      if (!is_new) oldest = std::min(oldest, health.verified);
    }
  }
  if (oldest != absl::InfiniteFuture()) all.oldest_verified = oldest;
  return all;
}

void BackupFolder::AddHealth(StoredBackup& backup) const {
  absl::MutexLock lock(&health_mutex_);
  const auto mission = health_.find(backup.mission);
  if (mission == health_.end()) return;
  const auto health = mission->second.find(backup.number);
  if (health == mission->second.end()) return;
  backup.verified = health->second.verified;
  backup.damage = health->second.damage;
}

bool BackupFolder::IsDamaged(absl::string_view mission, uint32_t number) const {
  StoredBackup backup{std::string(mission), number, 0, {}};
  AddHealth(backup);
  return !backup.damage.empty();
}

void BackupFolder::NoteHealth(absl::string_view mission, uint32_t number,
                              const absl::Status& compared) const {
  absl::MutexLock lock(&health_mutex_);
  HealthByNumber& backups = health_[std::string(mission)];
  BackupHealth& health = backups[number];
  const bool was_damaged = !health.damage.empty();
  health.damage = compared.ok() ? "" : absl::StrCat(compared.message(), kWhatToDo);
  if (compared.ok()) health.verified = absl::Now();
  LOG_IF(ERROR, !compared.ok() && !was_damaged)
      << "backup " << PlaceOf(mission, number) << " is damaged: " << compared;
  const absl::Status written = WriteBackupHealth(FolderOf(mission), backups);
  LOG_IF(WARNING, !written.ok()) << "that backups were compared is forgotten with the process: "
                                 << written;
}

void BackupFolder::ForgetHealth(absl::string_view mission, uint32_t number) const {
  absl::MutexLock lock(&health_mutex_);
  const auto backups = health_.find(std::string_view(mission.data(), mission.size()));
  if (backups != health_.end()) backups->second.erase(number);
}

std::vector<uint32_t> BackupFolder::ListNumbers(absl::string_view mission) const {
  std::vector<uint32_t> numbers;
  absl::MutexLock lock(&health_mutex_);
  const auto backups = health_.find(std::string_view(mission.data(), mission.size()));
  if (backups == health_.end()) return numbers;
  for (const auto& [number, health] : backups->second) numbers.push_back(number);
  return numbers;
}

absl::Status BackupFolder::Compare(absl::string_view mission,
                                   const std::function<bool(uint64_t bytes)>& pace) {
  const std::string folder = FolderOf(mission);
  const BackupPace goes_on = [&](uint64_t bytes) { return !interrupted_ && pace(bytes); };
  // What several backups share is read once.
  std::map<SummedFile, absl::Status> compared;
  for (const uint32_t number : ListNumbers(mission)) {
    const std::shared_ptr<const void> hold = Hold(mission, number);
    const absl::StatusOr<std::vector<SummedFile>> files = ReadBackupSums(folder, number);
    // It went meanwhile.
    if (absl::IsNotFound(files.status())) continue;
    absl::Status sound = files.status();
    for (size_t i = 0; sound.ok() && i < files->size(); ++i) {
      const SummedFile& file = (*files)[i];
      const auto known = compared.find(file);
      sound = known != compared.end() ? known->second : CompareWithSum(folder, file, goes_on);
      if (absl::IsCancelled(sound)) return sound;
      if (file.is_shared()) compared.emplace(file, sound);
    }
    std::error_code error;
    if (fs::exists(absl::StrCat(folder, "/meta/", number), error)) {
      NoteHealth(mission, number, sound);
    }
  }
  return absl::OkStatus();
}

absl::Status BackupFolder::CompareNew(rocksdb::DB& db, absl::string_view mission, uint32_t number,
                                      const std::function<bool()>& goes_on) const {
  const std::string folder = FolderOf(mission);
  const BackupPace pace = [&](uint64_t) { return !interrupted_ && goes_on(); };
  ASSIGN_OR_RETURN(const std::vector<SummedFile> files, ReadBackupSums(folder, number));
  for (const SummedFile& file : files) {
    const absl::Status compared = CompareWithSum(folder, file, pace);
    if (compared.ok()) continue;
    if (!absl::IsDataLoss(compared) || !file.is_shared()) return compared;
    LOG(ERROR) << compared << "; it is copied anew from the mission";
    RETURN_IF_ERROR(Mend(db, mission, file, pace));
  }
  return absl::OkStatus();
}

absl::Status BackupFolder::Mend(rocksdb::DB& db, absl::string_view mission, const SummedFile& file,
                                const BackupPace& pace) const {
  const std::string folder = FolderOf(mission);
  const SummedFile copy{file.name + ".mending", file.checksum};
  const fs::path from = absl::StrCat(db.GetName(), "/", LiveName(file));
  const fs::path made = absl::StrCat(folder, "/", copy.name);
  std::error_code error;
  fs::copy_file(from, made, fs::copy_options::overwrite_existing, error);
  absl::Status sound =
      error ? absl::UnavailableError(absl::StrCat("backup ", made.string(), ": ", error.message()))
            : CompareWithSum(folder, copy, pace);
  if (sound.ok()) fs::rename(made, absl::StrCat(folder, "/", file.name), error);
  if (sound.ok() && error) sound = absl::UnavailableError(error.message());
  if (!sound.ok()) {
    fs::remove(made, error);
    return sound;
  }
  RETURN_IF_ERROR(SyncFolder(absl::StrCat(folder, "/shared_checksum")));
  // Others that have it may be whole again: they are compared once more.
  absl::MutexLock lock(&health_mutex_);
  for (auto& [number, health] : health_[std::string(mission)]) {
    if (absl::StrContains(health.damage, file.name)) health.damage.clear();
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
