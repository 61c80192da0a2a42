// Tests that what somebody takes back is gone with all that followed from it, and is not believed
// again.
#include "map_store/records/retraction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::DeterministicOptions;
using testing::DumpPlaces;
using testing::FirstDifference;
using testing::JournalBytes;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";

// Two robots meet, and a third one is on the other side of the ring.
class RetractionTest : public ::testing::Test {
 protected:
  static std::unique_ptr<MapStore> Open(const std::shared_ptr<JournalBytes>& bytes,
                                        FusionWorker* worker,
                                        const MapStoreOptions& options = DeterministicOptions()) {
    auto store = std::make_unique<MapStore>(options, TheWorld().vocabulary,
                                            std::make_unique<ByteJournal>(bytes), worker);
    EXPECT_TRUE(store->Recover().ok());
    return store;
  }
  void StreamAll(MapStore& store) {
    for (const auto& [name, made] :
         {std::make_pair("a", &map_a_), std::make_pair("b", &map_b_), std::make_pair("c", &far_)}) {
      TestAgent agent(store, kMission, name, *made);
      ASSERT_TRUE(agent.Stream().ok());
      ASSERT_TRUE(agent.Close().ok());
    }
    ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  }
  static std::vector<OverlapInfo> Accepted(const MapStore& store, LocalMapId of) {
    OverlapFilter filter;
    filter.accepted = true;
    filter.local_map = of;
    return store.ListOverlaps(kMission, filter, {})->items;
  }
  static IslandId IslandOf(const MapStore& store, const SyntheticMap& made) {
    return store.GetLocalMap(kMission, made.map.keyframes().begin()->first.local_map)->island;
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  SyntheticMap far_ = MakeRingMap(0xc, 180, 14);
  TruthfulWorker honest_{{&map_a_, &map_b_, &far_}};
  TruthfulWorker liar_{{&map_a_, &map_b_, &far_}};
  std::shared_ptr<JournalBytes> bytes_ = std::make_shared<JournalBytes>();
};

TEST_F(RetractionTest, AWrongMergeIsUndoneAndTheRightOneStays) {
  liar_.lies_about = LocalMapId{0xc};
  auto store = Open(bytes_, &liar_);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*store));
  ASSERT_EQ(store->GetStatistics(kMission)->islands, 1u);
  const auto wrong = Accepted(*store, LocalMapId{0xc});
  ASSERT_EQ(wrong.size(), 1u);

  const auto taken_back = store->RetractOverlap(kMission, wrong[0].id, false);
  ASSERT_TRUE(taken_back.ok()) << taken_back.status();
  EXPECT_EQ(*taken_back, std::vector<uint64_t>{wrong[0].id});
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  EXPECT_EQ(store->GetStatistics(kMission)->islands, 2u);
  EXPECT_EQ(IslandOf(*store, map_a_), IslandOf(*store, map_b_));
  EXPECT_NE(IslandOf(*store, map_a_), IslandOf(*store, far_));
  EXPECT_TRUE(Accepted(*store, LocalMapId{0xc}).empty());

  auto never_had_it = Open(std::make_shared<JournalBytes>(), &honest_);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*never_had_it));
  for (MapStore* each : {store.get(), never_had_it.get()}) {
    ASSERT_TRUE(each->RederiveGlobalLayer(kMission).ok());
    ASSERT_TRUE(each->RunFusionUntilIdle(kMission).ok());
  }
  EXPECT_EQ(FirstDifference(DumpPlaces(kMission, *store), DumpPlaces(kMission, *never_had_it)), "");
}

TEST_F(RetractionTest, WhatIsKeptApartStaysApart) {
  auto store = Open(bytes_, &honest_);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*store));
  ASSERT_EQ(IslandOf(*store, map_a_), IslandOf(*store, map_b_));
  const auto between = Accepted(*store, LocalMapId{0xb});
  ASSERT_FALSE(between.empty());
  const auto taken_back = store->RetractOverlap(kMission, between[0].id, true);
  ASSERT_TRUE(taken_back.ok()) << taken_back.status();
  EXPECT_EQ(taken_back->size(), between.size());
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  EXPECT_NE(IslandOf(*store, map_a_), IslandOf(*store, map_b_));

  // Neither a rederivation nor a restart brings it back.
  ASSERT_TRUE(store->RederiveGlobalLayer(kMission).ok());
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  EXPECT_NE(IslandOf(*store, map_a_), IslandOf(*store, map_b_));
  const std::string before = testing::DumpGlobal(kMission, *store);
  store = Open(bytes_, &honest_);
  EXPECT_EQ(FirstDifference(testing::DumpGlobal(kMission, *store), before), "");
  const auto all = store->ListOverlaps(kMission, {}, {})->items;
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [](const OverlapInfo& info) {
    return info.overlap.verdict == OverlapVerdict::kTakenBack;
  }));
}

TEST_F(RetractionTest, WhatBentTheGraphOfMapsKeptApartIsNotTriedAgain) {
  MapStoreOptions options = DeterministicOptions();
  // Every keyframe is looked up, however well linked it is.
  options.overlap_spacing = 0;
  options.min_shared_landmarks = 100000;
  const auto first = Open(std::make_shared<JournalBytes>(), &honest_, options);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*first));
  const auto found = Accepted(*first, LocalMapId{0xb});
  ASSERT_GT(found.size(), 3u);
  const KeyframeId bad = found.back().overlap.query;
  honest_.bends_graph = [bad](const Overlap& overlap) { return overlap.query == bad; };
  auto store = Open(bytes_, &honest_, options);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*store));
  ASSERT_EQ(IslandOf(*store, map_a_), IslandOf(*store, map_b_));
  // The refused overlap would fit a graph without the others.
  honest_.bends_graph = nullptr;
  const auto between = Accepted(*store, LocalMapId{0xb});
  ASSERT_TRUE(store->RetractOverlap(kMission, between.at(0).id, true).ok());
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  EXPECT_NE(IslandOf(*store, map_a_), IslandOf(*store, map_b_));
}

TEST_F(RetractionTest, WhatElseTwoMapsHaveInCommonHoldsThemTogether) {
  auto store = Open(bytes_, &honest_);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*store));
  const auto between = Accepted(*store, LocalMapId{0xb});
  ASSERT_FALSE(between.empty());
  ASSERT_TRUE(store->RetractOverlap(kMission, between[0].id, false).ok());
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  EXPECT_EQ(IslandOf(*store, map_a_), IslandOf(*store, map_b_));
  for (const OverlapInfo& other : Accepted(*store, LocalMapId{0xb})) {
    EXPECT_NE(other.id, between[0].id);
  }
}

TEST_F(RetractionTest, RobotsForgetWhatTheyWereToldByIt) {
  auto store = Open(bytes_, &honest_);
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_FALSE(a.mirror().keyframes.empty());
  const auto between = Accepted(*store, LocalMapId{0xb});
  ASSERT_TRUE(store->RetractOverlap(kMission, between.at(0).id, true).ok());
  ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
  ASSERT_TRUE(a.TakeShared().ok());
  EXPECT_TRUE(a.mirror().keyframes.empty());
  EXPECT_TRUE(a.mirror().landmarks.empty());
}

TEST(CheckRetractionTest, ALocalMapIsNotKeptApartFromItself) {
  MissionState state;
  OverlapEntry loop;
  loop.id = 1;
  loop.overlap.query = {LocalMapId{0xa}, 90};
  loop.overlap.candidate = {LocalMapId{0xa}, 1};
  loop.state = OverlapState::kInGraph;
  state.global.overlaps.Add(loop);
  EXPECT_TRUE(map_store::CheckRetraction(state, {1, false}).ok());
  const absl::Status refused = map_store::CheckRetraction(state, {1, true});
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.message()), ::testing::HasSubstr("000000000000000a"));
}

TEST_F(RetractionTest, OnlyWhatIsAcceptedCanBeTakenBack) {
  auto store = Open(bytes_, &honest_);
  ASSERT_NO_FATAL_FAILURE(StreamAll(*store));
  EXPECT_EQ(store->RetractOverlap("nobody's", 1, false).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(store->RetractOverlap(kMission, 4711, false).status().code(),
            absl::StatusCode::kNotFound);
  const auto between = Accepted(*store, LocalMapId{0xb});
  ASSERT_TRUE(store->RetractOverlap(kMission, between.at(0).id, false).ok());
  const auto again = store->RetractOverlap(kMission, between.at(0).id, false);
  EXPECT_EQ(again.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(again.status().message()), ::testing::HasSubstr("TAKEN_BACK"));
}

}  // namespace
}  // namespace corbslam::map_store
