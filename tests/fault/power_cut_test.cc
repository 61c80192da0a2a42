// The power goes while four robots stream recorded uploads: what the disk then holds against what
// was acknowledged, and against a store that nobody disturbed. The disk keeps what was synced, and
// nothing else: a kill keeps all that was written.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "fusion_worker/local_fusion_worker.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/unsynced_loss_env.h"
#include "tests/fault/replay_fixture.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;
using map_store::MapStore;

namespace {

constexpr char kMission[] = "cut";
constexpr size_t kRobots = 4;
constexpr int kCutsOfADrive = 10;

// CORBSLAM_POWER_CUTS: how many.
int CutsWanted() { return CountFromEnvironment("CORBSLAM_POWER_CUTS", 4); }

LocalMapId MapOf(size_t robot) { return LocalMapId{0xa0 + robot}; }

// The number of each robot's last batch.
using LastBatches = std::array<uint64_t, kRobots>;

struct PowerCut {
  std::string folder;  // Folder with what the disk holds.
  LastBatches acknowledged = {};
};

class PowerCutTest : public ReplayFaultTest {
 protected:
  static uint64_t LastBatch(const MapStore& store, size_t robot) {
    const auto info = store.GetLocalMap(kMission, MapOf(robot));
    return info.ok() ? info->last_batch : 0;
  }

  // Sends the robot's batches from the first one that the store does not have to the one with
  // number `last`.
  void Send(size_t robot, uint64_t last, MapStore& store, std::atomic<uint64_t>* acknowledged) {
    SessionRequest request;
    request.mission = kMission;
    request.agent = absl::StrCat("agent", robot);
    const auto session = store.OpenSession(request);
    ASSERT_TRUE(session.ok()) << session.status();
    for (uint64_t number = LastBatch(store, robot) + 1; number <= last; ++number) {
      const auto stored =
          store.Apply(session->session_id, AsLocalMap(uploads_[number - 1], MapOf(robot)));
      ASSERT_TRUE(stored.ok()) << stored.status();
      if (acknowledged != nullptr) *acknowledged = stored->number;
    }
  }
  // Sends first batches so that local maps arrive in the same order each time.
  void SendFirstBatches(MapStore& store) {
    for (size_t robot = 0; robot < kRobots; ++robot) Send(robot, 1, store, nullptr);
  }
  void SendTheRest(MapStore& store) {
    SendFirstBatches(store);
    for (size_t robot = 0; robot < kRobots; ++robot) Send(robot, uploads_.size(), store, nullptr);
  }

  // Returns numbers of acknowledgements, in order, from the first batches of all to all batches but
  // the last.
  std::vector<uint64_t> RandomMoments(int count, std::mt19937& random) const {
    std::uniform_int_distribution<uint64_t> any(kRobots, kRobots * uploads_.size() - 1);
    std::vector<uint64_t> moments;
    for (int i = 0; i < count; ++i) moments.push_back(any(random));
    std::ranges::sort(moments);
    return moments;
  }

  // All robots stream at once; the power is cut again and again, as far as the disk is concerned.
  std::vector<PowerCut> Drive(bool sync, int cuts, std::mt19937& random) {
    testing::UnsyncedLossEnv env;
    const std::string folder = FileOf("live");
    std::filesystem::remove_all(folder);
    auto store = Reopen(
        {.directory = folder, .min_bytes_between_snapshots = 1 << 20, .sync = sync, .env = &env},
        worker_.get(), /*deterministic=*/false);
    EXPECT_NE(store, nullptr);
    if (store == nullptr) return {};
    SendFirstBatches(*store);
    std::array<std::atomic<uint64_t>, kRobots> acknowledged;
    std::vector<std::thread> robots;
    for (size_t robot = 0; robot < kRobots; ++robot) {
      acknowledged[robot] = 1;
      robots.emplace_back([this, robot, &store, &acknowledged] {
        Send(robot, uploads_.size(), *store, &acknowledged[robot]);
      });
    }
    const auto count = [&acknowledged] {
      return std::accumulate(acknowledged.begin(), acknowledged.end(), uint64_t{0});
    };
    std::vector<PowerCut> made;
    for (const uint64_t moment : RandomMoments(cuts, random)) {
      const absl::Time deadline = absl::Now() + absl::Seconds(60);
      while (count() < moment && absl::Now() < deadline) absl::SleepFor(absl::Microseconds(50));
      // The power may also go in the middle of a batch.
      absl::SleepFor(absl::Microseconds(std::uniform_int_distribution<int>(0, 3000)(random)));
      PowerCut cut{.folder = FileOf(absl::StrCat("cut", made.size())), .acknowledged = {}};
      // Acknowledgements are copied before the disk is looked at, because there may be more by
      // then.
      std::copy(acknowledged.begin(), acknowledged.end(), cut.acknowledged.begin());
      env.CopyAfterPowerCut(folder, cut.folder);
      made.push_back(cut);
    }
    for (std::thread& robot : robots) robot.join();
    return made;
  }

  // Counts acknowledged batches that the store does not have.
  static uint64_t CountLost(const PowerCut& cut, const MapStore* store) {
    uint64_t lost = 0;
    for (size_t robot = 0; robot < kRobots; ++robot) {
      const uint64_t found = store == nullptr ? 0 : LastBatch(*store, robot);
      lost += cut.acknowledged[robot] - std::min(cut.acknowledged[robot], found);
    }
    return lost;
  }
  bool IsInTheMiddle(const PowerCut& cut) const {
    return *std::ranges::min_element(cut.acknowledged) < uploads_.size();
  }

  const RecordedUploads uploads_ = RecordDemo();
  std::unique_ptr<FusionWorker> worker_ = MakeLocalFusionWorker({});
};

TEST_F(PowerCutTest, HoldsWhatTheUndisturbedStoreHolds) {
  const auto undisturbed = Reopen({.directory = FileOf("undisturbed")}, worker_.get());
  ASSERT_NE(undisturbed, nullptr);
  ASSERT_NO_FATAL_FAILURE(SendTheRest(*undisturbed));
  const std::string local = LocalLayer(kMission, *undisturbed);
  const std::string global = FuseAgain(kMission, *undisturbed);
  EXPECT_EQ(undisturbed->GetStatistics(kMission)->islands, 1u);

  std::mt19937 random(7);
  const int wanted = CutsWanted();
  int cuts = 0;
  int in_the_middle = 0;
  while (cuts < wanted) {
    const std::vector<PowerCut> made = Drive(true, std::min(kCutsOfADrive, wanted - cuts), random);
    ASSERT_FALSE(made.empty());
    for (const PowerCut& cut : made) {
      ++cuts;
      in_the_middle += IsInTheMiddle(cut) ? 1 : 0;
      const auto store = Reopen({.directory = cut.folder}, worker_.get());
      ASSERT_NE(store, nullptr) << cut.folder;
      EXPECT_EQ(CountLost(cut, store.get()), 0u);
      ASSERT_NO_FATAL_FAILURE(SendTheRest(*store));
      EXPECT_EQ(testing::FirstDifference(LocalLayer(kMission, *store), local), "");
      EXPECT_EQ(testing::FirstDifference(FuseAgain(kMission, *store), global), "");
    }
  }
  std::printf("%d power cuts, %d while robots streamed: 0 acknowledged batches lost\n", cuts,
              in_the_middle);
  EXPECT_GT(in_the_middle, cuts / 2) << "the robots were too fast for the test";
}

TEST_F(PowerCutTest, AStoreThatNeverSyncsIsFoundOut) {
  std::mt19937 random(7);
  uint64_t lost = 0;
  for (const PowerCut& cut : Drive(false, kCutsOfADrive, random)) {
    lost += CountLost(cut, Reopen({.directory = cut.folder}, worker_.get()).get());
  }
  EXPECT_GT(lost, 0u) << "the test can't tell";
}

}  // namespace
}  // namespace corbslam::tests
