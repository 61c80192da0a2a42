// Tests a store whose robot starts again and again at one place: its old sessions become one local
// map, and nobody is the worse for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "map_store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/recover_whole.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::JournalBytes;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;

constexpr char kOneRobot[] = "r";
constexpr size_t kStarts = 4;
constexpr uint32_t kKeyframesOfDrive = 10;

std::vector<SyntheticMap> MakeDrives() {
  std::vector<SyntheticMap> drives;
  for (uint64_t session = 1; session <= kStarts; ++session) {
    drives.push_back(
        testing::MakeRingMap(session, static_cast<double>(session), kKeyframesOfDrive));
  }
  return drives;
}

// A store in which one robot starts four times; the newest session stays as it is.
class OneRobotsStore {
 public:
  explicit OneRobotsStore(bool joins)
      : worker_({&drives_[0], &drives_[1], &drives_[2], &drives_[3]}),
        store_(Options(joins), TheWorld().vocabulary, std::make_unique<ByteJournal>(bytes_),
               &worker_) {}

  static MapStoreOptions Options(bool joins) {
    MapStoreOptions options = testing::DeterministicOptions();
    options.join_local_maps = joins;
    options.keep_local_maps = 1;
    return options;
  }
  void Start(size_t session) {
    agents_.push_back(std::make_unique<TestAgent>(store_, "m", kOneRobot, drives_[session]));
    ASSERT_TRUE(agents_.back()->Stream().ok());
    ASSERT_TRUE(agents_.back()->Close().ok());
    ASSERT_TRUE(store_.RunFusionUntilIdle("m").ok());
  }
  void StartAll() {
    for (size_t session = 0; session < kStarts; ++session) Start(session);
  }
  MapStore& store() { return store_; }
  TestAgent& agent(size_t session) { return *agents_[session]; }
  const std::shared_ptr<JournalBytes>& bytes() const { return bytes_; }

 private:
  const std::vector<SyntheticMap> drives_ = MakeDrives();
  testing::TruthfulWorker worker_;
  std::shared_ptr<JournalBytes> bytes_ = std::make_shared<JournalBytes>();
  MapStore store_;
  std::vector<std::unique_ptr<TestAgent>> agents_;
};

TEST(JoiningTest, OldSessionsBecomeOneAndFusionGoesOn) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const auto info = joined.store().GetMission("m");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->local_maps, 2u);
  EXPECT_EQ(info->keyframes, kStarts * kKeyframesOfDrive);
  EXPECT_EQ(joined.store().GetStatistics("m")->islands, 1u) << "the last start was fused, too";
  const auto whole = joined.store().GetLocalMap("m", {3});
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(whole->id, LocalMapId{1});
  EXPECT_THAT(whole->joined, ::testing::ElementsAre(LocalMapId{2}, LocalMapId{3}));
  EXPECT_TRUE(joined.store().GetKeyframe("m", {{2}, 3}).ok()) << "ids stay";
}

TEST(JoiningTest, ARestartGivesTheSame) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const std::string local = testing::DumpLocal("m", joined.store());
  const std::string global = testing::DumpGlobal("m", joined.store());
  for (const bool from_snapshot : {false, true}) {
    if (from_snapshot) {
      joined.bytes()->wants_snapshot = true;
      ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
    }
    MapStore again(OneRobotsStore::Options(true), TheWorld().vocabulary,
                   std::make_unique<ByteJournal>(joined.bytes()), nullptr);
    const absl::Status recovered = testing::RecoverWhole(again);
    ASSERT_TRUE(recovered.ok()) << recovered;
    EXPECT_EQ(testing::FirstDifference(testing::DumpLocal("m", again), local), "");
    EXPECT_EQ(testing::FirstDifference(testing::DumpGlobal("m", again), global), "");
  }
}

TEST(JoiningTest, UnlessToldToEachStaysOne) {
  OneRobotsStore apart(false);
  apart.StartAll();
  EXPECT_EQ(apart.store().GetMission("m")->local_maps, kStarts);
}

TEST(JoiningTest, ABatchForASessionThatIsAPartIsRefused) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const absl::Status status = joined.agent(1).Send(joined.agent(1).EmptyBatch());
  EXPECT_TRUE(absl::IsAborted(status) || absl::IsFailedPrecondition(status)) << status;
}

TEST(JoiningTest, SessionsAreDeletedForGood) {
  OneRobotsStore joined(true);
  joined.StartAll();
  ForgetRequest request{.agent = kOneRobot, .before_ns = {}, .keep = 1, .dry_run = true};
  auto forgotten = joined.store().ForgetLocalMaps("m", request);
  ASSERT_TRUE(forgotten.ok()) << forgotten.status();
  EXPECT_EQ(forgotten->keyframes, 3 * kKeyframesOfDrive);
  EXPECT_EQ(forgotten->parts, 2u);
  EXPECT_EQ(joined.store().GetMission("m")->local_maps, 2u) << "it was a question";
  request.dry_run = false;
  ASSERT_TRUE(joined.store().ForgetLocalMaps("m", request).ok());
  ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
  EXPECT_EQ(joined.store().GetMission("m")->keyframes, kKeyframesOfDrive);
  EXPECT_FALSE(joined.store().GetKeyframe("m", {{2}, 3}).ok());
  MapStore again(OneRobotsStore::Options(true), TheWorld().vocabulary,
                 std::make_unique<ByteJournal>(joined.bytes()), nullptr);
  const absl::Status recovered = testing::RecoverWhole(again);
  ASSERT_TRUE(recovered.ok()) << recovered;
  EXPECT_EQ(testing::FirstDifference(testing::DumpLocal("m", again),
                                     testing::DumpLocal("m", joined.store())),
            "");
}

}  // namespace
}  // namespace corbslam::map_store
