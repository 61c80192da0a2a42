#include "tests/fault/replay_fixture.h"

#include <glog/logging.h>

#include <utility>

#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/store_dump.h"
#include "services/programs/default_vocabulary.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::RocksJournal;
using map_store::RocksJournalOptions;
using services::DefaultVocabularyPath;

ReplayFaultTest::ReplayFaultTest() {
  auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
  EXPECT_TRUE(vocabulary.ok()) << vocabulary.status();
  vocabulary_ = *vocabulary;
}

RecordedUploads ReplayFaultTest::RecordDemo() const {
  auto uploads = RecordUploads(DemoSource(), vocabulary_);
  EXPECT_TRUE(uploads.ok()) << uploads.status();
  return *std::move(uploads);
}

std::unique_ptr<MapStore> ReplayFaultTest::Reopen(const RocksJournalOptions& journal_options,
                                                  FusionWorker* worker, bool deterministic) const {
  auto journal = RocksJournal::Open(journal_options);
  if (!journal.ok()) {
    LOG(WARNING) << journal.status();
    return nullptr;
  }
  MapStoreOptions options;
  options.deterministic = deterministic;
  auto store = std::make_unique<MapStore>(options, vocabulary_, *std::move(journal), worker);
  const absl::Status recovered = testing::RecoverUndamaged(*store);
  if (recovered.ok()) return store;
  LOG(WARNING) << recovered;
  return nullptr;
}

std::string ReplayFaultTest::LocalLayer(const std::string& mission, MapStore& store) {
  EXPECT_TRUE(store.RederiveGlobalLayer(mission).ok());
  return testing::DumpLocal(mission, store) + testing::DumpPlaces(mission, store);
}

std::string ReplayFaultTest::FuseAgain(const std::string& mission, MapStore& store) {
  EXPECT_TRUE(store.RunFusionUntilIdle(mission).ok());
  return testing::DumpPlaces(mission, store);
}

}  // namespace corbslam::tests
