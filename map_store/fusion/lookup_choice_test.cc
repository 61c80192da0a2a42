// Tests how many look-ups workers are asked for, where every place looks like every other.
#include "map_store/fusion/lookup_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "map_store/map_store.h"
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

struct Row {
  size_t look_ups = 0;
  size_t most_of_a_keyframe = 0;
  size_t islands = 0;
};

// So many robots drive a part of the ring each, one after the other; each part overlaps with those
// before and behind it, by some keyframes. Words tell nothing apart.
Row FuseRow(size_t robots, bool one_robot) {
  std::vector<SyntheticMap> maps;
  std::vector<const SyntheticMap*> pointers;
  for (size_t i = 0; i < robots; ++i) {
    maps.push_back(MakeRingMap(0xa + i, 28.0 * static_cast<double>(i), kKeyframes));
  }
  for (const SyntheticMap& map : maps) pointers.push_back(&map);
  TruthfulWorker worker(pointers);
  MapStoreOptions options = DeterministicOptions();
  options.min_shared_words = 1;
  options.min_shared_words_ratio = 0;
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  for (size_t i = 0; i < robots; ++i) {
    TestAgent agent(store, kMission, one_robot ? "r" : std::to_string(i), maps[i]);
    EXPECT_TRUE(agent.Stream().ok());
    EXPECT_TRUE(agent.Close().ok());
    EXPECT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  }
  Row row;
  std::map<KeyframeId, size_t> of_keyframe;
  for (const TruthfulWorker::Asked& asked : worker.asked()) {
    ++row.look_ups;
    row.most_of_a_keyframe = std::max(row.most_of_a_keyframe, ++of_keyframe[asked.query]);
  }
  row.islands = store.GlobalMapView(kMission)->size();
  return row;
}

TEST(LookupChoiceTest, LookUpsGrowWithKeyframesNotWithLocalMaps) {
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

TEST(LookupChoiceTest, ARobotsNextLocalMapIsHeldAgainstItsLastBesideTheBest) {
  const Row twelve = FuseRow(12, true);
  EXPECT_EQ(twelve.islands, 1u);
  EXPECT_LE(twelve.most_of_a_keyframe, 4u);
}

// A mission may be deleted, or derived anew, between the claim of a lane and the choice.
TEST(LookupChoiceTest, OfAnEmptyQueueNothingIsChosen) {
  UnbrokenRead read;
  const auto chosen = ChooseLookups(MissionState(), DeterministicOptions(), read);
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_TRUE(chosen->empty());
}

}  // namespace
}  // namespace corbslam::map_store
