// Opens one mission's database that nobody writes to, in a backup or in a folder, as a journal.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_READER_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_READER_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/records/journal.h"
#include "map_store/rocks/read_only_journal.h"

namespace rocksdb {
class Env;
}  // namespace rocksdb

namespace corbslam::map_store {
class MissionJournal;

// Thread-safe.
class BackupReader : public ReadOnlyJournal {
 public:
  // Opens the database at `path`, as `env` has it, which `keep` keeps alive as long as the result
  // lives. DATA_LOSS names what is damaged.
  static absl::StatusOr<std::unique_ptr<Journal>> Open(const std::string& mission,
                                                       const std::string& path, rocksdb::Env* env,
                                                       std::shared_ptr<const void> keep);
  ~BackupReader() override;

  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override;
  absl::Status Damage(absl::string_view mission) const override;
  absl::StatusOr<KeyframePicture> ReadPicture(absl::string_view mission,
                                              KeyframeId keyframe) const override;
  absl::Status ForEachPicture(
      absl::string_view mission,
      const std::function<absl::Status(const KeyframePicture& picture)>& visit) const override;

 private:
  BackupReader(std::string mission, std::unique_ptr<MissionJournal> journal,
               std::shared_ptr<const void> keep);

  // Declared first, so that it goes last.
  const std::shared_ptr<const void> keep_;
  const std::unique_ptr<MissionJournal> journal_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_READER_H_
