// Tests how many queries workers are asked for, where every place looks like every other.
#include "map_store/fusion/query_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";
constexpr int kKeyframes = 9;

struct Drives {
  size_t robots = 0;
  double apart_degrees = 0;  // Along the ring, from the begin of one to that of the next.
  bool one_robot = false;    // True: all are sessions of one.
};

struct Row {
  size_t look_ups = 0;
  size_t of_the_last = 0;            // Those of the last drive's keyframes.
  size_t of_the_last_in_itself = 0;  // The same, in its own local map: loops.
  size_t most_of_a_keyframe = 0;
  size_t islands = 0;
};

// The drives follow one another; fusion comes to rest after each.
Row Fuse(const Drives& drives, const MapStoreOptions& options) {
  std::vector<SyntheticMap> maps;
  std::vector<const SyntheticMap*> pointers;
  for (size_t i = 0; i < drives.robots; ++i) {
    maps.push_back(MakeRingMap(0xa + i, drives.apart_degrees * static_cast<double>(i), kKeyframes));
  }
  for (const SyntheticMap& map : maps) pointers.push_back(&map);
  TruthfulWorker worker(pointers);
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  for (size_t i = 0; i < drives.robots; ++i) {
    TestAgent agent(store, kMission, drives.one_robot ? "r" : std::to_string(i), maps[i]);
    EXPECT_TRUE(agent.Stream().ok());
    EXPECT_TRUE(agent.Close().ok());
    EXPECT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  }
  Row row;
  std::map<KeyframeId, size_t> of_keyframe;
  const LocalMapId last = {0xa + drives.robots - 1};
  for (const TruthfulWorker::Asked& asked : worker.asked()) {
    ++row.look_ups;
    row.of_the_last += asked.query.local_map == last;
    row.of_the_last_in_itself +=
        asked.query.local_map == last && asked.candidates.front().local_map == last;
    row.most_of_a_keyframe = std::max(row.most_of_a_keyframe, ++of_keyframe[asked.query]);
  }
  row.islands = store.GlobalMapView(kMission)->size();
  return row;
}

// Each drives a part of the ring that overlaps with those before and behind it, by some keyframes.
// Words tell nothing apart.
Row FuseRow(size_t robots, bool one_robot) {
  MapStoreOptions options = DeterministicOptions();
  options.min_shared_words = 1;
  options.min_shared_words_ratio = 0;
  return Fuse({robots, 28.0, one_robot}, options);
}

// All drive the same part of the ring, and no landmarks say that a place is known.
Row FuseVisits(size_t robots) {
  MapStoreOptions options = DeterministicOptions();
  options.overlap_spacing = 2;
  options.min_shared_landmarks = 100000;
  return Fuse({robots, 0.3, false}, options);
}

TEST(QueryChoiceTest, QueriesGrowWithKeyframesNotWithLocalMaps) {
  const Row four = FuseRow(4, false);
  const Row eight = FuseRow(8, false);
  const Row twelve = FuseRow(12, false);
  EXPECT_EQ(four.islands, 1u);
  EXPECT_EQ(eight.islands, 1u);
  EXPECT_EQ(twelve.islands, 1u);
  EXPECT_LE(twelve.most_of_a_keyframe, 3u);
  EXPECT_LE(twelve.look_ups, 3 * 12 * kKeyframes);
  EXPECT_LE(twelve.look_ups - eight.look_ups, (eight.look_ups - four.look_ups) * 5 / 4);
}

TEST(QueryChoiceTest, ARobotsNextLocalMapIsHeldAgainstItsLastBesideTheBest) {
  const Row twelve = FuseRow(12, true);
  EXPECT_EQ(twelve.islands, 1u);
  EXPECT_LE(twelve.most_of_a_keyframe, 4u);
}

// Where two others hold a place already, eight more visits of it are not asked, too.
TEST(QueryChoiceTest, KnownGroundCostsTheSameHoweverOftenItWasVisited) {
  const Row four = FuseVisits(4);
  const Row twelve = FuseVisits(12);
  EXPECT_EQ(four.islands, 1u);
  EXPECT_EQ(twelve.islands, 1u);
  EXPECT_GT(four.of_the_last, 0u);
  EXPECT_LE(twelve.of_the_last, four.of_the_last);
}

// What a drive saw before looks as much like the place as what others saw.
TEST(QueryChoiceTest, OnKnownGroundADriveIsStillHeldAgainstItself) {
  MapStoreOptions options = DeterministicOptions();
  options.overlap_spacing = 2;
  options.min_shared_landmarks = 100000;
  options.min_loop_gap = 2;
  EXPECT_GT(Fuse({6, 0.3, false}, options).of_the_last_in_itself, 0u);
}

class NextToQueryTest : public ::testing::Test {
 protected:
  NextToQueryTest() {
    for (const LocalMapId id : {kJoined, kPartner, kAlone}) {
      AddLocalMap(state_, id, ToString(id));
      state_.queries.Push({id, 1}, {kPartner});
    }
    Island& island = state_.global.islands.at(state_.global.island_of.at(kJoined));
    state_.global.islands.erase(state_.global.island_of.at(kPartner));
    state_.global.island_of[kPartner] = island.id;
    island.local_maps.push_back(kPartner);
  }

  static constexpr LocalMapId kJoined{0xa};
  static constexpr LocalMapId kPartner{0xb};
  static constexpr LocalMapId kAlone{0xc};
  MissionState state_;
};

TEST_F(NextToQueryTest, NothingIsChosenWhereNothingWaits) {
  state_.queries.Clear();
  EXPECT_FALSE(ChooseNextToQuery(state_).IsValid());
}

TEST_F(NextToQueryTest, WhoIsNotJoinedComesFirst) {
  EXPECT_EQ(ChooseNextToQuery(state_), kAlone);
  state_.FindLocalMap(kAlone)->closed = true;
  EXPECT_EQ(ChooseNextToQuery(state_), kAlone);
}

TEST_F(NextToQueryTest, WhoDrivesComesBeforeWhoHasEnded) {
  state_.queries.BringForward(kAlone);
  state_.queries.PopFront();
  EXPECT_EQ(ChooseNextToQuery(state_), kJoined) << "it has waited longest";
  state_.FindLocalMap(kJoined)->closed = true;
  EXPECT_EQ(ChooseNextToQuery(state_), kPartner);
}

// A mission may be deleted, or derived anew, between the claim of a lane and the choice.
TEST(QueryChoiceTest, OfAnEmptyQueueNothingIsChosen) {
  UnbrokenRead read;
  const auto chosen = ChooseQueriedMaps(MissionState(), DeterministicOptions(), read);
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_TRUE(chosen->empty());
}

}  // namespace
}  // namespace corbslam::map_store
