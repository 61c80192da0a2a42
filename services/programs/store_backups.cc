#include "services/programs/store_backups.h"

#include <glog/logging.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "map_store/rocks/backup_folder.h"
#include "services/observe/metrics/backup_collector.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::BackupFolder;
using map_store::BackupKeeper;
using map_store::BackupOptions;
using map_store::BackupVerifier;
using map_store::MapStore;
using map_store::RocksJournal;
using map_store::StoredBackups;

absl::StatusOr<std::unique_ptr<StoreBackups>> StoreBackups::Make(const BackupFlags& flags,
                                                                 MapStore* store,
                                                                 const RocksJournal* journal) {
  std::unique_ptr<StoreBackups> made(new StoreBackups(journal));
  ASSIGN_OR_RETURN(made->every_, ParseBackupInterval(flags));
  if (flags.directory.empty() || journal == nullptr) return made;
  BackupOptions options;
  options.directory = flags.directory;
  options.take_over_from = flags.take_over_from;
  options.bytes_per_s = static_cast<uint64_t>(flags.mb_per_s * 1e6);
  ASSIGN_OR_RETURN(std::unique_ptr<BackupFolder> folder, BackupFolder::Open(journal, options));
  made->backups_ =
      std::make_unique<StoredBackups>(store, std::move(folder), flags.keep, &absl::Now);
  StoredBackups* backups = made->backups_.get();
  const absl::Duration least_age = made->every_ / 2;
  made->keeper_ = std::make_unique<BackupKeeper>(
      made->every_, &absl::Now,
      [journal]() -> absl::StatusOr<std::vector<std::string>> { return journal->ListMissions(); },
      [backups, least_age](const std::string& mission) {
        return backups->StoreIfChanged(mission, least_age);
      });
  made->verifier_ = std::make_unique<BackupVerifier>(
      static_cast<uint64_t>(flags.scrub_mb_per_s * 1e6),
      [backups](const BackupVerifier::Pace& pace) { return backups->CompareAll(pace); });
  return made;
}

void StoreBackups::Start() {
  if (verifier_ != nullptr) verifier_->Start();
  if (keeper_ != nullptr) keeper_->Start();
}

void StoreBackups::Stop() {
  if (backups_ != nullptr) backups_->Interrupt();
  if (keeper_ != nullptr) keeper_->Stop();
  if (verifier_ != nullptr) verifier_->Stop();
}

std::shared_ptr<prometheus::Collectable> StoreBackups::MakeCollector() const {
  BackupCollector::CountBackups backups;
  if (keeper_ != nullptr) backups = [keeper = keeper_.get()] { return keeper->counts(); };
  BackupCollector::CountScrubs scrubs;
  if (journal_ != nullptr) scrubs = [journal = journal_] { return journal->scrub_counts(); };
  BackupCollector::DescribeHealth health;
  if (backups_ != nullptr) {
    health = [stored = backups_.get(), verifier = verifier_.get()] {
      return BackupCollector::Health{stored->health(), verifier->counts()};
    };
  }
  return std::make_shared<BackupCollector>(std::move(backups),
                                           keeper_ != nullptr ? every_ : absl::ZeroDuration(),
                                           std::move(scrubs), std::move(health));
}

}  // namespace corbslam::services
