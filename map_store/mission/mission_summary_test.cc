#include "map_store/mission/mission_summary.h"

#include <gtest/gtest.h>

#include <string>

namespace corbslam::map_store {
namespace {

MissionSummary MakeMissionSummary() {
  MissionSummary summary;
  summary.info.name = "lab";
  summary.info.revision = 7;
  summary.info.agents = 2;
  summary.info.local_maps = 3;
  summary.info.islands = 1;
  summary.info.keyframes = 400;
  summary.info.map_points = 50000;
  summary.info.fusion_idle = false;
  summary.info.waiting_queries = 5;
  summary.info.memory_bytes = 1 << 30;
  summary.info.profile.last_used_ns = 1'700'000'000'000'000'000;
  summary.load.mission = "lab";
  summary.load.keyframes = 401;
  summary.load.joined_local_maps = 21;
  summary.load.forgotten_local_maps = 22;
  summary.load.retired_keyframes = 23;
  summary.load.faded_points = 24;
  summary.load.overlaps_queried = 11;
  summary.load.waiting = {.verify = 1, .fuse = 2, .adjust = 3};
  summary.load.longest_write_s = 0.25;
  summary.work_left = true;
  summary.retired = true;
  return summary;
}

TEST(MissionSummaryTest, ComesBackAsItWas) {
  const auto read = DecodeSummary(EncodeSummary(MakeMissionSummary()));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(EncodeSummary(*read), EncodeSummary(MakeMissionSummary()));
  EXPECT_EQ(read->info.name, "lab");
  EXPECT_EQ(read->info.map_points, 50000u);
  EXPECT_FALSE(read->info.fusion_idle);
  EXPECT_EQ(read->info.profile.last_used_ns, 1'700'000'000'000'000'000);
  EXPECT_EQ(read->load.keyframes, 401u);
  EXPECT_EQ(read->load.joined_local_maps, 21u);
  EXPECT_EQ(read->load.forgotten_local_maps, 22u);
  EXPECT_EQ(read->load.retired_keyframes, 23u);
  EXPECT_EQ(read->load.faded_points, 24u);
  EXPECT_EQ(read->load.waiting.adjust, 3u);
  EXPECT_EQ(read->load.longest_write_s, 0.25);
  EXPECT_TRUE(read->work_left);
  EXPECT_TRUE(read->retired);
}

TEST(MissionSummaryTest, AnotherFormatAndCutBytesAreRefused) {
  std::string bytes = EncodeSummary(MakeMissionSummary());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_TRUE(absl::IsDataLoss(DecodeSummary(bytes.substr(0, size)).status())) << size;
  }
  EXPECT_TRUE(absl::IsDataLoss(DecodeSummary(bytes + "x").status()));
  ++bytes[0];
  EXPECT_TRUE(absl::IsDataLoss(DecodeSummary(bytes).status()));
}

}  // namespace
}  // namespace corbslam::map_store
