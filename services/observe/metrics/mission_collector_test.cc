#include "services/observe/metrics/mission_collector.h"

#include <gtest/gtest.h>

#include "map_store/mission/mission_load.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"
#include "services/observe/metrics/testing/metric_values.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MissionStatistics;

namespace {

using testing::MakeRingMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;
using testing::ValueOf;

class MissionCollectorTest : public ::testing::Test {
 protected:
  std::optional<double> Value(const std::string& name, testing::LabelMap labels = {}) {
    labels["mission"] = "lab";
    return ValueOf(collector_.Collect(), name, labels);
  }

  testing::SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  testing::SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  MapStore store_{testing::DeterministicOptions(), TheWorld().vocabulary,
                  std::make_unique<InMemoryJournal>(), &worker_};
  MapStoreService service_{&store_};
  prometheus::Registry registry_;
  IngestMetrics ingest_{registry_};
  MissionCollector collector_{&store_, &service_, &ingest_};
};

TEST_F(MissionCollectorTest, SaysWhatTheStoresStatisticsSay) {
  TestAgent a(store_, "lab", "a", map_a_);
  TestAgent b(store_, "lab", "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  const double queries = Value("corbslam_fusion_requests_waiting", {{"kind", "verify"}}).value();
  EXPECT_GT(queries, 0) << "nobody has worked on them yet";
  EXPECT_EQ(Value("corbslam_mission_islands"), 2);
  EXPECT_EQ(Value("corbslam_mission_agents_connected"), 2);
  ASSERT_TRUE(store_.RunFusionUntilIdle("lab").ok());
  store_.CloseSession(b.session());
  const MissionStatistics statistics = *store_.GetStatistics("lab");
  EXPECT_EQ(Value("corbslam_mission_keyframes"), statistics.keyframes);
  EXPECT_GE(Value("corbslam_mission_map_points"), statistics.map_points);
  EXPECT_EQ(Value("corbslam_mission_retired_keyframes"), 0) << "nothing is closed";
  EXPECT_EQ(Value("corbslam_mission_faded_points"), 0);
  EXPECT_GT(Value("corbslam_mission_memory_bytes"), 10'000);
  EXPECT_EQ(Value("corbslam_mission_disk_bytes"), 0) << "its journal is in memory";
  EXPECT_EQ(ValueOf(collector_.Collect(), "corbslam_missions_damaged", {}), 0);
  EXPECT_EQ(Value("corbslam_mission_islands"), 1);
  EXPECT_EQ(Value("corbslam_mission_local_maps"), 2);
  EXPECT_EQ(Value("corbslam_mission_agents"), 2);
  EXPECT_EQ(Value("corbslam_mission_agents_connected"), 1);
  EXPECT_EQ(Value("corbslam_mission_revision"), statistics.revision);
  EXPECT_EQ(Value("corbslam_mission_overlaps_accepted"), statistics.overlaps_accepted);
  EXPECT_EQ(Value("corbslam_mission_overlaps_total", {{"stage", "queried"}}),
            statistics.overlaps_queried);
  for (const char* kind : {"verify", "fuse", "adjust"}) {
    EXPECT_EQ(Value("corbslam_fusion_requests_waiting", {{"kind", kind}}), 0) << kind;
  }
}

TEST_F(MissionCollectorTest, SaysThatNoWorkerAnswers) {
  const auto answer = [this] {
    return ValueOf(collector_.Collect(), "corbslam_fusion_workers_answer", {});
  };
  EXPECT_EQ(answer(), 1);
  TestAgent a(store_, "lab", "a", map_a_);
  TestAgent b(store_, "lab", "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  worker_.verify_failures.assign(1000, absl::UnavailableError("gone"));
  ASSERT_TRUE(store_.RunFusionUntilIdle("lab").ok());
  EXPECT_EQ(answer(), 0);
}

TEST_F(MissionCollectorTest, WhatAWorkerHasTakenWaitsNoMore) {
  TestAgent a(store_, "lab", "a", map_a_);
  TestAgent b(store_, "lab", "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  const double before = Value("corbslam_fusion_requests_waiting", {{"kind", "verify"}}).value();
  std::optional<double> during_verify;
  std::optional<double> during_fuse;
  worker_.during_verify = [&] {
    if (during_verify) return;
    during_verify = Value("corbslam_fusion_requests_waiting", {{"kind", "verify"}});
  };
  worker_.during_fuse = [&] {
    during_fuse = Value("corbslam_fusion_requests_waiting", {{"kind", "fuse"}});
  };
  ASSERT_TRUE(store_.RunFusionUntilIdle("lab").ok());
  ASSERT_TRUE(during_verify.has_value());
  // Queries without candidates leave the queue without a worker.
  EXPECT_LT(*during_verify, before);
  EXPECT_EQ(during_fuse, 0);
}

TEST_F(MissionCollectorTest, ADeletedMissionsSeriesAreGone) {
  TestAgent a(store_, "lab", "a", map_a_);
  EXPECT_EQ(Value("corbslam_mission_agents"), 1);
  ASSERT_TRUE(store_.DeleteMission("lab").ok());
  EXPECT_EQ(Value("corbslam_mission_agents"), std::nullopt);
  EXPECT_EQ(ValueOf(collector_.Collect(), "corbslam_missions"), 0);
}

}  // namespace
}  // namespace corbslam::services
