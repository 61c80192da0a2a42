// A store whose one robot starts again and again at one place of the ring.
#ifndef CORBSLAM_MAP_STORE_TESTING_ONE_ROBOTS_STORE_H_
#define CORBSLAM_MAP_STORE_TESTING_ONE_ROBOTS_STORE_H_

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::testing {

inline constexpr char kOneRobot[] = "r";
inline constexpr size_t kStarts = 4;
inline constexpr uint32_t kKeyframesOfDrive = 10;

inline std::vector<SyntheticMap> MakeDrives() {
  std::vector<SyntheticMap> drives;
  for (uint64_t session = 1; session <= kStarts; ++session) {
    drives.push_back(MakeRingMap(session, static_cast<double>(session), kKeyframesOfDrive));
  }
  return drives;
}

// One robot starts four times in mission "m", with local maps 1 to 4; the newest session stays as
// it is, and where sessions are joined the others become one.
class OneRobotsStore {
 public:
  explicit OneRobotsStore(bool joins)
      : OneRobotsStore(Options(joins), std::make_shared<JournalBytes>()) {}
  // With the journal's bytes, which outlive the store.
  OneRobotsStore(const map_store::MapStoreOptions& options, std::shared_ptr<JournalBytes> bytes)
      : worker_({&drives_[0], &drives_[1], &drives_[2], &drives_[3]}),
        bytes_(std::move(bytes)),
        store_(options, TheWorld().vocabulary, std::make_unique<ByteJournal>(bytes_), &worker_) {}

  static map_store::MapStoreOptions Options(bool joins) {
    map_store::MapStoreOptions options = DeterministicOptions();
    options.join_local_maps = joins;
    options.keep_local_maps = 1;
    return options;
  }
  // Streams a session and closes it, without fusing.
  void Drive(size_t session) {
    agents_.push_back(std::make_unique<TestAgent>(store_, "m", kOneRobot, drives_[session]));
    ASSERT_TRUE(agents_.back()->Stream().ok());
    ASSERT_TRUE(agents_.back()->Close().ok());
  }
  void Start(size_t session) {
    Drive(session);
    ASSERT_TRUE(store_.RunFusionUntilIdle("m").ok());
  }
  void StartAll() {
    for (size_t session = 0; session < kStarts; ++session) Start(session);
  }
  map_store::MapStore& store() { return store_; }
  TestAgent& agent(size_t session) { return *agents_[session]; }
  const std::vector<SyntheticMap>& drives() const { return drives_; }
  const std::shared_ptr<JournalBytes>& bytes() const { return bytes_; }

 private:
  const std::vector<SyntheticMap> drives_ = MakeDrives();
  TruthfulWorker worker_;
  std::shared_ptr<JournalBytes> bytes_;
  map_store::MapStore store_;
  std::vector<std::unique_ptr<TestAgent>> agents_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_ONE_ROBOTS_STORE_H_
