#include "map_store/rocks/backup_reader.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::StatusOr<std::unique_ptr<Journal>> BackupReader::Open(const std::string& mission,
                                                            const std::string& path,
                                                            rocksdb::Env* env,
                                                            std::shared_ptr<const void> keep) {
  auto database = std::make_unique<RocksDatabase>(path, env, MakeBlockCache());
  const rocksdb::Status opened = database->Open(RocksDatabase::Mode::kOnlyRead);
  if (!opened.ok()) return absl::DataLossError(absl::StrCat(path, ": ", opened.ToString()));
  RocksJournalOptions options;
  options.directory = path;
  options.only_read = true;
  auto journal = std::make_unique<MissionJournal>(mission, options, std::move(database));
  const absl::Status loaded = journal->Load();
  if (absl::IsNotFound(loaded)) return absl::DataLossError(loaded.message());
  RETURN_IF_ERROR(loaded);
  return std::unique_ptr<Journal>(new BackupReader(mission, std::move(journal), std::move(keep)));
}

BackupReader::BackupReader(std::string mission, std::unique_ptr<MissionJournal> journal,
                           std::shared_ptr<const void> keep)
    : ReadOnlyJournal(std::move(mission)), keep_(std::move(keep)), journal_(std::move(journal)) {}

BackupReader::~BackupReader() = default;

absl::StatusOr<Journal::Position> BackupReader::Recover(absl::string_view name,
                                                        const Replay& replay) const {
  if (name == mission()) return journal_->Recover(replay);
  return absl::NotFoundError(absl::StrCat("the backup is of mission ", mission()));
}

absl::StatusOr<KeyframePicture> BackupReader::ReadPicture(absl::string_view,
                                                          KeyframeId keyframe) const {
  return journal_->ReadPicture(keyframe);
}

absl::Status BackupReader::ForEachPicture(
    absl::string_view,
    const std::function<absl::Status(const KeyframePicture& picture)>& visit) const {
  return journal_->ForEachPicture(visit);
}

absl::Status BackupReader::Damage(absl::string_view) const { return journal_->Damage(); }

}  // namespace corbslam::map_store
