// Holds what fault tests share that stream a robot's recorded uploads, and then read the journal in
// their own process.
#ifndef CORBSLAM_TESTS_FAULT_REPLAY_FIXTURE_H_
#define CORBSLAM_TESTS_FAULT_REPLAY_FIXTURE_H_

#include <memory>
#include <string>

#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "slam/vocabulary/vocabulary.h"
#include "tests/fault/fault_fixture.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

class ReplayFaultTest : public FaultTest {
 protected:
  ReplayFaultTest();

  // Returns what a robot uploaded on the demo's recording.
  RecordedUploads RecordDemo() const;

  // Opens what the journal holds in a store that fuses with `worker` (not owned; null: never). It
  // is deterministic, on this thread, when it is told to be. Returns null, and says why in the log,
  // where the journal can't be opened.
  std::unique_ptr<map_store::MapStore> Reopen(const map_store::RocksJournalOptions& journal,
                                              FusionWorker* worker,
                                              bool deterministic = true) const;

  // Returns all that owners said, of which fusion is made to know nothing.
  static std::string LocalLayer(const std::string& mission, map_store::MapStore& store);
  // Fuses, and returns where everything is then.
  static std::string FuseAgain(const std::string& mission, map_store::MapStore& store);

  std::shared_ptr<const Vocabulary> vocabulary_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_REPLAY_FIXTURE_H_
