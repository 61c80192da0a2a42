// Has the journal on a disk, and the one in memory, pass the tests of any journal.
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "map_store/records/journal.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/testing/journal_conformance.h"
#include "map_store/testing/unsynced_loss_env.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DurableJournalConformance;
using testing::JournalConformance;
using testing::JournalKind;
using testing::JournalPlace;

class MemoryPlace : public JournalPlace {
 public:
  absl::StatusOr<std::unique_ptr<Journal>> Open(uint64_t) override {
    return std::make_unique<InMemoryJournal>();
  }
};

class FolderPlace : public JournalPlace {
 public:
  FolderPlace() {
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  ~FolderPlace() override { fs::remove_all(root_); }

  absl::StatusOr<std::unique_ptr<Journal>> Open(uint64_t min_bytes_between_snapshots) override {
    auto journal = RocksJournal::Open({.directory = folder_.string(),
                                       .min_bytes_between_snapshots = min_bytes_between_snapshots,
                                       .env = &env_});
    if (!journal.ok()) return journal.status();
    return *std::move(journal);
  }
  void LosePower() override {
    const fs::path after = root_ / "after";
    env_.CopyAfterPowerCut(folder_.string(), after.string());
    folder_ = after;
  }
  void Spoil(const std::string& mission) override {
    for (const auto& entry :
         fs::directory_iterator(JournalFolder(folder_.string()).PathOf(mission))) {
      const fs::path& path = entry.path();
      if (path.extension() == ".log" || path.extension() == ".sst") SpoilFile(path);
    }
  }

 private:
  static void SpoilFile(const fs::path& path) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(path) / 2));
    file << "spoiled";
  }

  const fs::path root_ = fs::path(::testing::TempDir()) / "rocks_conformance" /
                         ::testing::UnitTest::GetInstance()->current_test_info()->name();
  fs::path folder_ = root_ / "data";
  testing::UnsyncedLossEnv env_;
};

template <typename Place>
JournalKind Kind(const std::string& name) {
  return {name, [] { return std::make_unique<Place>(); }};
}

INSTANTIATE_TEST_SUITE_P(Rocks, JournalConformance,
                         ::testing::Values(Kind<FolderPlace>("Folder"),
                                           Kind<MemoryPlace>("Memory")),
                         [](const auto& info) { return info.param.name; });
INSTANTIATE_TEST_SUITE_P(Rocks, DurableJournalConformance,
                         ::testing::Values(Kind<FolderPlace>("Folder")),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace corbslam::map_store
