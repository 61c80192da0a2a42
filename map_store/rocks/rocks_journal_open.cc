// Implements the part of RocksJournal that opens its folder and makes missions in it.
#include <glog/logging.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "map_store/archive/formats.h"
#include "map_store/rocks/files_check.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/journal_scrubber.h"
#include "map_store/rocks/journal_tidier.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/mission_lists.h"
#include "map_store/rocks/rocks_database.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/rocks/summary_file.h"
#include "map_store/rocks/upgrade_copy.h"
#include "slam/util/lock_holder.h"
#include "slam/util/program_version.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

using Mode = RocksDatabase::Mode;

// RocksDB locks this file of the folder as long as it has the database open.
constexpr char kLockName[] = "LOCK";

// Says why a database can't be opened, with the process that has it open, where there is one.
std::string ExplainOpenFailure(const std::string& directory, const rocksdb::Status& status) {
  const std::string said = status.ToString();
  const bool is_locked = absl::StrContains(said, "While lock file") ||
                         absl::StrContains(said, "lock hold by current process");
  if (!is_locked) return said;
  const std::string lock = absl::StrCat(directory, "/", kLockName);
  return absl::StrCat("the folder is in use: ", DescribeLockHolder(lock),
                      "; stop it, or choose another folder");
}

// Returns whether a database can't be opened because of what is, or is not, in its files.
bool IsDamage(const rocksdb::Status& status) {
  const std::string said = status.ToString();
  return status.IsCorruption() || absl::StrContains(said, "No such file") ||
         absl::StrContains(said, "does not exist") || absl::StrContains(said, "Input/output error");
}

// An open database always has a log, so that one without has lost it.
bool HasLog(const std::string& directory) {
  std::error_code error;
  for (std::filesystem::directory_iterator it(directory, error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() == ".log") return true;
  }
  return false;
}

}  // namespace

absl::Status RocksJournal::OpenFailure(const std::string& path, const rocksdb::Status& status) {
  const std::string message = absl::StrCat("journal ", path, ": ", status.ToString());
  if (IsDamage(status)) return absl::DataLossError(message);
  if (status.IsNoSpace()) return absl::ResourceExhaustedError(message);
  return absl::UnavailableError(message);
}

RocksJournal::RocksJournal(const RocksJournalOptions& options)
    : options_(options), folder_(options.directory), cache_(MakeBlockCache()) {}

absl::StatusOr<std::unique_ptr<RocksJournal>> RocksJournal::Open(
    const RocksJournalOptions& options) {
  std::unique_ptr<RocksJournal> journal(new RocksJournal(options));
  if (options.only_read) {
    RETURN_IF_ERROR(journal->PassGuard());
    RETURN_IF_ERROR(journal->LoadMissions());
    return journal;
  }
  std::error_code error;
  std::filesystem::create_directories(options.directory, error);
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat("journal ", options.directory, ": ", error.message()));
  }
  RETURN_IF_ERROR(journal->OpenGuard());
  RETURN_IF_ERROR(journal->LoadMissions());
  for (const MissionList list : {MissionList::kDeleted, MissionList::kPromised}) {
    ShortenMissionList(options.directory, list);
  }
  journal->tidier_ =
      std::make_unique<JournalTidier>([made = journal.get()] { return made->OpenMissions(); });
  journal->StartScrubber();
  return journal;
}

absl::Status RocksJournal::OpenGuard() {
  guard_ = std::make_unique<RocksDatabase>(options_.directory, options_.env, cache_);
  const rocksdb::Status opened = guard_->Open(Mode::kMake);
  const std::string place = absl::StrCat("journal ", options_.directory, ": ");
  if (!opened.ok() && !IsDamage(opened)) {
    return absl::FailedPreconditionError(place + ExplainOpenFailure(options_.directory, opened));
  }
  const absl::StatusOr<uint32_t> format =
      opened.ok() ? ReadGuard() : absl::DataLossError(opened.ToString());
  if (absl::IsFailedPrecondition(format.status()) ||
      (absl::IsDataLoss(format.status()) && !folder_.exists())) {
    return absl::Status(format.status().code(), place + std::string(format.status().message()));
  }
  if (!folder_.exists()) {
    if (format.ok())
      return absl::DataLossError(place + "the folder " + folder_.path() + " is lost");
    RETURN_IF_ERROR(folder_.Make());
    return WriteGuard();
  }
  // Once there is a folder of missions, the guard has nothing that could be lost.
  if (!format.ok()) return MakeGuard();
  // Programs that read no newer format are kept out before the first mission has one.
  if (*format != kJournalFormat) {
    RETURN_IF_ERROR(KeepOlder(*format));
    return WriteGuard();
  }
  std::string program;
  const bool is_known = guard_->Get(map_store::ProgramKey(), &program).ok();
  // Nothing depends on it.
  if (!is_known || program != CorbslamVersion()) WriteGuard().IgnoreError();
  return absl::OkStatus();
}

absl::Status RocksJournal::KeepOlder(uint32_t format) {
  RETURN_IF_ERROR(KeepBeforeUpgrade(options_.directory, format));
  LOG(WARNING) << "journal " << options_.directory << ": it is of format " << format
               << " and becomes " << kJournalFormat << "; as it was, for the program before this "
               << "one, it is kept in " << UpgradeCopyPath(options_.directory, format)
               << ", to be deleted when nobody wants to go back";
  return absl::OkStatus();
}

absl::Status RocksJournal::PassGuard() {
  const std::string place = absl::StrCat("journal ", options_.directory, ": ");
  std::error_code error;
  const bool has_guard = std::filesystem::exists(options_.directory + "/CURRENT", error);
  if (has_guard || folder_.exists()) {
    guard_ = std::make_unique<RocksDatabase>(options_.directory, options_.env, cache_);
    const rocksdb::Status opened = guard_->Open(Mode::kOpen);
    if (!opened.ok() && !IsDamage(opened)) {
      return absl::FailedPreconditionError(place + ExplainOpenFailure(options_.directory, opened));
    }
    const absl::Status known = opened.ok() ? ReadGuard().status() : absl::OkStatus();
    if (absl::IsFailedPrecondition(known)) {
      return absl::FailedPreconditionError(place + std::string(known.message()));
    }
  }
  // A damaged guard keeps nobody out, and is made anew at the next start.
  if (folder_.exists()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(place, "there is no folder ", folder_.path(), ": no map_store has used it"));
}

absl::StatusOr<uint32_t> RocksJournal::ReadGuard() {
  std::string bytes;
  const rocksdb::Status found = guard_->Get(map_store::FormatKey(), &bytes);
  if (found.IsNotFound()) return absl::NotFoundError("no format");
  if (!found.ok()) return absl::DataLossError(found.ToString());
  std::string program;
  if (!guard_->Get(map_store::ProgramKey(), &program).ok()) program.clear();
  return CheckFormat(bytes, program);
}

absl::Status RocksJournal::MakeGuard() {
  guard_->Close();
  RocksDatabase::Destroy(options_.directory);
  guard_ = std::make_unique<RocksDatabase>(options_.directory, options_.env, cache_);
  const rocksdb::Status made = guard_->Open(Mode::kMake);
  if (made.ok()) return WriteGuard();
  return absl::FailedPreconditionError(
      absl::StrCat("journal ", options_.directory, ": ", made.ToString()));
}

absl::Status RocksJournal::WriteGuard() {
  rocksdb::WriteBatch batch;
  batch.Put(map_store::FormatKey(), EncodeFormat());
  batch.Put(map_store::ProgramKey(), CorbslamVersion());
  const rocksdb::Status written = guard_->Write(batch, true);
  if (written.ok()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("journal ", options_.directory, ": ", written.ToString()));
}

absl::Status RocksJournal::LoadMissions() {
  if (!options_.only_read) RETURN_IF_ERROR(folder_.RemoveLeftovers());
  ASSIGN_OR_RETURN(const std::vector<std::string> names, folder_.ListInUse());
  for (const std::string& name : names) {
    // What only reads is there to find damage.
    const absl::Status aside = options_.only_read ? absl::NotFoundError("not asked for")
                                                  : ReadSummaryFile(folder_.PathOf(name)).status();
    LOG_IF(WARNING, absl::IsDataLoss(aside)) << "mission " << name << " is opened: " << aside;
    if (!aside.ok()) {
      RETURN_IF_ERROR(LoadMission(name));
      continue;
    }
    absl::MutexLock lock(&mutex_);
    aside_.insert(name);
  }
  return absl::OkStatus();
}

absl::Status RocksJournal::LoadMission(const std::string& name) {
  absl::StatusOr<MissionPtr> opened = OpenMission(name);
  if (opened.ok()) {
    const absl::Status loaded = (*opened)->Load();
    if (absl::IsNotFound(loaded) && options_.only_read) return absl::OkStatus();
    if (absl::IsNotFound(loaded)) {
      LOG(WARNING) << "mission " << name << " goes, its making was cut short: " << loaded;
      opened->reset();
      RETURN_IF_ERROR(folder_.Turn(name, kInUse, kDeleted));
      return folder_.Remove(name, kDeleted);
    }
    if (!loaded.ok()) opened = loaded;
  }
  absl::MutexLock lock(&mutex_);
  if (opened.ok()) {
    missions_[name] = *std::move(opened);
  } else if (absl::IsDataLoss(opened.status())) {
    unreadable_[name] = NameDamagedFiles(folder_.PathOf(name), opened.status());
  } else {
    return opened.status();
  }
  return absl::OkStatus();
}

absl::StatusOr<RocksJournal::MissionPtr> RocksJournal::OpenMission(const std::string& name) const {
  const std::string path = folder_.PathOf(name);
  if (!HasLog(path)) {
    return absl::DataLossError(absl::StrCat("journal ", path, ": its log (*.log) is lost"));
  }
  auto database = std::make_unique<RocksDatabase>(path, options_.env, cache_);
  const rocksdb::Status opened = database->Open(options_.only_read ? Mode::kOnlyRead : Mode::kOpen);
  if (!opened.ok()) return OpenFailure(path, opened);
  return std::make_shared<MissionJournal>(name, options_, std::move(database));
}

absl::Status RocksJournal::MakeFolder(const std::string& name) const {
  RETURN_IF_ERROR(folder_.Remove(name, kBeingMade));
  const std::string path = folder_.PathOf(name, kBeingMade);
  auto database = std::make_unique<RocksDatabase>(path, options_.env, cache_);
  const rocksdb::Status opened = database->Open(Mode::kMake);
  if (!opened.ok()) return OpenFailure(path, opened);
  {
    MissionJournal begun(name, options_, std::move(database));
    RETURN_IF_ERROR(begun.Begin());
  }
  return folder_.Turn(name, kBeingMade, kInUse);
}

absl::StatusOr<RocksJournal::MissionPtr> RocksJournal::MakeMission(absl::string_view mission) {
  const std::string name(mission);
  absl::MutexLock making(&making_);
  if (absl::StatusOr<MissionPtr> found = FindMission(name); !absl::IsNotFound(found.status())) {
    return found;
  }
  // An attempt that could not open it has left it behind.
  std::error_code error;
  if (!std::filesystem::exists(folder_.PathOf(name), error)) RETURN_IF_ERROR(MakeFolder(name));
  ASSIGN_OR_RETURN(MissionPtr made, OpenMission(name));
  absl::MutexLock lock(&mutex_);
  return missions_[name] = std::move(made);
}

}  // namespace corbslam::map_store
