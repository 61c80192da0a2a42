#include "services/corbslam/mission_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string MapName(int id) { return absl::StrCat("missions/lab/localMaps/", id); }

void AddLocalMap(int id, const std::string& agent, int island, MissionSummary& summary) {
  v1::LocalMap& local_map = summary.local_maps.emplace_back();
  local_map.set_name(MapName(id));
  local_map.set_agent("missions/lab/agents/" + agent);
  local_map.set_island(MapName(island));
  local_map.set_in_global_frame(island == 1);
  local_map.set_keyframes(10);
  local_map.set_map_points(100);
  local_map.set_tracked_frames(50);
}

void AddOverlap(int query, int candidate, v1::OverlapVerdict verdict, uint32_t inliers,
                MissionSummary& summary) {
  v1::Overlap& overlap = summary.overlaps.emplace_back();
  overlap.set_query(MapName(query) + "/keyframes/3");
  overlap.set_candidate(MapName(candidate) + "/keyframes/4");
  overlap.set_verdict(verdict);
  overlap.set_inliers(inliers);
}

// Alpha's first local map and bravo's are fused, alpha's second one is apart.
MissionSummary MakeSummary() {
  MissionSummary summary;
  summary.mission.set_name("missions/lab");
  summary.mission.set_agents(2);
  summary.mission.set_local_maps(3);
  summary.mission.set_islands(2);
  summary.mission.set_keyframes(30);
  for (const char* name : {"alpha", "bravo"}) {
    summary.agents.emplace_back().set_name(absl::StrCat("missions/lab/agents/", name));
  }
  summary.agents[0].set_connected(true);
  AddLocalMap(1, "alpha", 1, summary);
  AddLocalMap(2, "bravo", 1, summary);
  AddLocalMap(3, "alpha", 3, summary);
  summary.agents[0].add_local_maps(MapName(1));
  summary.agents[0].add_local_maps(MapName(3));
  AddOverlap(2, 1, v1::OVERLAP_VERDICT_ACCEPTED, 45, summary);
  AddOverlap(1, 2, v1::OVERLAP_VERDICT_ACCEPTED, 31, summary);
  AddOverlap(2, 1, v1::OVERLAP_VERDICT_TOO_FEW_WORD_MATCHES, 3, summary);
  AddOverlap(3, 1, v1::OVERLAP_VERDICT_NO_SECOND_KEYFRAME, 0, summary);
  AddOverlap(1, 1, v1::OVERLAP_VERDICT_ACCEPTED, 60, summary);
  return summary;
}

TEST(MissionSummaryTest, SaysWhatWasFusedAndWhyTheRestWasNot) {
  EXPECT_THAT(
      FormatSummary(MakeSummary()),
      AllOf(HasSubstr("Mission lab: 2 robots, 3 local maps in 2 islands, 30 keyframes, "),
            HasSubstr("alpha            yes                2        20       200       100"),
            HasSubstr("alpha/2          3                alpha/2          no"),
            HasSubstr("5 overlaps verified, 3 accepted\n"),
            HasSubstr("  alpha/1 and bravo/1, fused: 2 accepted (up to 45 inliers); 1 refused: too "
                      "few keypoints look alike\n"),
            HasSubstr("  alpha/1 and alpha/2, apart: 1 refused: no second pair of keyframes "
                      "agrees\n"),
            HasSubstr("  alpha/1, loops: 1 accepted (up to 60 inliers)\n"),
            HasSubstr("  bravo/1 and alpha/2, apart: no two keyframes share enough words to be "
                      "compared\n")));
}

TEST(MissionSummaryTest, HasTheSameAsJson) {
  const nlohmann::ordered_json json = ToJson(MakeSummary());
  EXPECT_EQ(json["mission"]["name"], "missions/lab");
  EXPECT_EQ(json["agents"].size(), 2u);
  EXPECT_EQ(json["agents"][0]["local_maps"].size(), 2u);
  EXPECT_EQ(json["local_maps"][2]["short_name"], "alpha/2");
  EXPECT_EQ(json["overlaps"], 5);
  EXPECT_EQ(json["pairs"].size(), 4u);
  for (const auto& pair : json["pairs"]) {
    if (pair["local_maps"].dump() != R"(["alpha/1","bravo/1"])") continue;
    EXPECT_EQ(pair["accepted"], 2);
    EXPECT_EQ(pair["verdicts"]["OVERLAP_VERDICT_TOO_FEW_WORD_MATCHES"], 1);
    EXPECT_EQ(pair["same_island"], true);
    return;
  }
  ADD_FAILURE() << "no pair of alpha/1 and bravo/1 in " << json.dump(2);
}

TEST(MissionSummaryTest, DescribesEveryVerdict) {
  for (int i = v1::OverlapVerdict_MIN; i <= v1::OverlapVerdict_MAX; ++i) {
    if (!v1::OverlapVerdict_IsValid(i) || i == v1::OVERLAP_VERDICT_UNSPECIFIED) continue;
    EXPECT_THAT(DescribeVerdict(static_cast<v1::OverlapVerdict>(i)),
                ::testing::Not(HasSubstr("verdict ")));
  }
}

}  // namespace
}  // namespace corbslam
