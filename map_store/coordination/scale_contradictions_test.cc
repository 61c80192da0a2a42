// Tests that local maps are kept apart of which a robot says that they differ too much in size.
#include "map_store/coordination/scale_contradictions.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::DeterministicOptions;
using testing::JournalBytes;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMissionOfTwo[] = "m";

// Two robots met; both are still there.
class ScaleContradictionsTest : public ::testing::Test {
 protected:
  ScaleContradictionsTest() : store_(Open()) {
    for (TestAgent* agent : {&alpha_, &bravo_}) EXPECT_TRUE(agent->Stream().ok());
    EXPECT_TRUE(store_->RunFusionUntilIdle(kMissionOfTwo).ok());
    EXPECT_EQ(Islands(*store_), 1u);
  }

  std::unique_ptr<MapStore> Open() {
    auto store = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                            std::make_unique<ByteJournal>(bytes_), &worker_);
    EXPECT_TRUE(store->Recover().ok());
    return store;
  }
  static uint64_t Islands(const MapStore& store) {
    return store.GetStatistics(kMissionOfTwo)->islands;
  }
  // Lets bravo say how large another local map is, and fusion do what follows; returns the number
  // of islands.
  uint64_t Say(LocalMapId others, double scale) {
    AgentReport report;
    report.contradictions = {{others, scale, 0.001}};
    EXPECT_TRUE(store_->NoteReport(bravo_.session(), report).ok());
    EXPECT_TRUE(store_->RunFusionUntilIdle(kMissionOfTwo).ok());
    return Islands(*store_);
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  std::shared_ptr<JournalBytes> bytes_ = std::make_shared<JournalBytes>();
  std::unique_ptr<MapStore> store_;
  TestAgent alpha_{*store_, kMissionOfTwo, "alpha", map_a_};
  TestAgent bravo_{*store_, kMissionOfTwo, "bravo", map_b_};
};

TEST_F(ScaleContradictionsTest, WhatDiffersTooMuchIsKeptApartForEver) {
  EXPECT_EQ(Say(alpha_.local_map(), 1.014), 2u);
  EXPECT_EQ(Say(alpha_.local_map(), 1.014), 2u) << "it is said again with each report";
  store_.reset();
  store_ = Open();
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMissionOfTwo).ok());
  EXPECT_EQ(Islands(*store_), 2u);
}

TEST_F(ScaleContradictionsTest, SmallerAndLargerCountAlike) {
  EXPECT_EQ(Say(alpha_.local_map(), 0.985), 2u);
}

TEST_F(ScaleContradictionsTest, WhatDiffersByLessStaysFused) {
  EXPECT_EQ(Say(alpha_.local_map(), 1.0099), 1u);
  EXPECT_EQ(Say(alpha_.local_map(), 0.9901), 1u);
}

TEST_F(ScaleContradictionsTest, WhatIsBentIsPutRightTogether) {
  AgentReport report;
  report.contradictions = {{alpha_.local_map(), 1, 0, MapBend{4.5, 0.13, 0.012}}};
  EXPECT_TRUE(store_->NoteReport(bravo_.session(), report).ok());
  EXPECT_TRUE(store_->RunFusionUntilIdle(kMissionOfTwo).ok());
  EXPECT_EQ(Islands(*store_), 1u);
}

TEST_F(ScaleContradictionsTest, ARobotSpeaksOfOthersMapsAndForItsOwn) {
  EXPECT_EQ(Say(bravo_.local_map(), 1.014), 1u);
  EXPECT_EQ(Say(LocalMapId{0xff}, 1.014), 1u) << "nobody knows that local map";
}

TEST_F(ScaleContradictionsTest, WhatItMadeBeforeMayBeOfAnotherCalibration) {
  ASSERT_TRUE(bravo_.Close().ok());
  ASSERT_TRUE(bravo_.Close().ok());
  EXPECT_EQ(Say(alpha_.local_map(), 1.014), 1u);
}

}  // namespace
}  // namespace corbslam::map_store
