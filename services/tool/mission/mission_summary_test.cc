#include "services/tool/mission/mission_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "services/convert/geometry.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string MapName(int id) { return absl::StrCat("missions/lab/localMaps/", id); }

void AddLocalMap(int id, const std::string& agent, int island, MissionSummary& summary) {
  v1::LocalMap& local_map = summary.local_maps.emplace_back();
  local_map.set_name(MapName(id));
  local_map.set_agent("missions/lab/agents/" + agent);
  local_map.set_island(MapName(island));
  local_map.set_in_global_frame(island == 1);
  local_map.set_keyframes(10);
  local_map.set_settled_keyframes(7);
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

// Makes a mission in which alpha's first local map and bravo's are fused, and alpha's second one is
// apart.
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
  v1::LastPose& last = *summary.agents[0].mutable_last_pose();
  last.set_timestamp_ns(5);
  last.set_local_map(MapName(3));
  last.set_island(MapName(3));
  last.set_lost_since(true);
  ToProto(Rigid3d{Eigen::Quaterniond::Identity(), {-1.25, 0, 2}},
          last.mutable_camera_from_island());
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

TEST(MissionSummaryTest, SaysWhichMapsRobotsGoWithout) {
  MissionSummary summary = MakeSummary();
  v1::MapContradiction* found = summary.agents[1].mutable_report()->add_contradictions();
  found->set_local_map(0xab);
  found->set_scale(0.986);
  found->set_scale_sigma(0.0016);
  EXPECT_THAT(
      FormatSummary(summary),
      HasSubstr("bravo goes without 00000000000000ab, which is 1.40 % smaller than what its "
                "camera measures (+-0.16 %)\n"));
  found->mutable_bend()->set_way_m(4.5);
  found->mutable_bend()->set_shift_m(0.127);
  found->mutable_bend()->set_turn_rad(0.0122);
  EXPECT_THAT(FormatSummary(summary),
              HasSubstr("bravo goes without 00000000000000ab, which is bent: over 4.5 m its camera "
                        "ends 0.13 m beside, turned by 0.70 degrees\n"));
}

TEST(MissionSummaryTest, SaysWhichLengthsAreNoMetres) {
  MissionSummary summary = MakeSummary();
  EXPECT_THAT(FormatSummary(summary), Not(HasSubstr("without metres")));
  summary.local_maps[1].set_without_metres(true);
  summary.local_maps[2].set_without_metres(true);
  summary.local_maps[2].set_island_without_metres(true);
  EXPECT_THAT(FormatSummary(summary),
              AllOf(HasSubstr("without metres: alpha/2 (made with one camera alone; no map with"),
                    HasSubstr("without metres of their own: bravo/1 (")));
  const nlohmann::ordered_json json = ToJson(summary);
  EXPECT_EQ(json["local_maps"][1]["without_metres"], true);
  EXPECT_EQ(json["local_maps"][1]["island_without_metres"], false);
}

TEST(MissionSummaryTest, SaysWhatWasFusedAndWhyTheRestWasNot) {
  EXPECT_THAT(
      FormatSummary(MakeSummary()),
      AllOf(HasSubstr("Mission lab: 2 robots, 3 local maps in 2 islands, 30 keyframes, "),
            HasSubstr("alpha            yes                2        20       200       100"),
            HasSubstr(" 1.25 0.00 -2.00 in the frame of alpha/2, lost since\n"),
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

TEST(MissionSummaryTest, SaysWhatAMissionCostsAndWhatIsDamaged) {
  MissionSummary summary = MakeSummary();
  summary.mission.set_memory_bytes(3 << 19);
  summary.mission.set_disk_bytes(42 << 20);
  summary.mission.set_fusion_idle(true);
  EXPECT_THAT(FormatSummary(summary), HasSubstr("about 1.5 MiB in memory, 42.0 MiB on disk\n"));
  EXPECT_EQ(FormatSummary(summary).find("DAMAGED"), std::string::npos);
  EXPECT_THAT(FormatMissions({summary.mission}), HasSubstr("        1.5       42.0 idle\n"));
  EXPECT_EQ(ToJson(summary)["mission"]["disk_bytes"], 42 << 20);
  summary.mission.set_asleep(true);
  EXPECT_THAT(FormatSummary(summary), HasSubstr("42.0 MiB on disk\nIt was asleep until now\n"));
  EXPECT_THAT(FormatMissions({summary.mission}), HasSubstr("        0.0       42.0 asleep\n"));
  EXPECT_EQ(ToJson(summary)["mission"]["asleep"], true);
  summary.mission.set_damage("000012.sst: a block; delete the mission");
  EXPECT_THAT(FormatSummary(summary), HasSubstr("\nDAMAGED: 000012.sst: a block; delete the"));
  EXPECT_THAT(FormatMissions({summary.mission}), HasSubstr("damaged: see `corbslam mission show`"));
}

// Robots that stand, have finished, only localise or died are told apart.
TEST(MissionSummaryTest, SaysWhatRobotsAreDoing) {
  MissionSummary summary = MakeSummary();
  v1::MissionAgent& alpha = summary.agents[0];
  const auto says = [&](const std::string& text) { return HasSubstr(text); };
  EXPECT_THAT(FormatSummary(summary), says("       100         0  -                       1.25"));
  v1::AgentReport& report = *alpha.mutable_report();
  report.set_activity(v1::AGENT_ACTIVITY_TRACKING);
  report.set_frames(9);
  EXPECT_THAT(FormatSummary(summary), says("         0  tracking  "));
  alpha.set_report_age_s(31.2);
  EXPECT_THAT(FormatSummary(summary), says("  tracking, 31 s ago  "));
  report.set_activity(v1::AGENT_ACTIVITY_WAITING);
  report.set_newest_frame_age_s(10);
  EXPECT_THAT(FormatSummary(summary), says("  no frame for 41 s  "));
  report.set_activity(v1::AGENT_ACTIVITY_FINISHED);
  alpha.set_report_age_s(2);
  EXPECT_THAT(FormatSummary(summary), says("  finished  "));
  alpha.set_connected(false);
  EXPECT_THAT(FormatSummary(summary), says("  its line broke  "));
  alpha.set_left_on_purpose(true);
  EXPECT_THAT(FormatSummary(summary), says("  ended  "));
  EXPECT_EQ(ToJson(summary)["agents"][0]["report"]["activity"], "AGENT_ACTIVITY_FINISHED");
  EXPECT_EQ(ToJson(summary)["agents"][0]["left_on_purpose"], true);
}

TEST(MissionSummaryTest, FramesOfARobotThatOnlyLocalisesAreItsOwn) {
  MissionSummary summary = MakeSummary();
  v1::MissionAgent& guest = summary.agents.emplace_back();
  guest.set_name("missions/lab/agents/guest");
  guest.set_connected(true);
  guest.set_localise_only(true);
  EXPECT_THAT(FormatSummary(summary), HasSubstr("        -         -  localises"));
  guest.mutable_report()->set_activity(v1::AGENT_ACTIVITY_LOST);
  guest.mutable_report()->set_tracked(71);
  guest.mutable_report()->set_lost(3);
  EXPECT_THAT(FormatSummary(summary), HasSubstr("       71         3  lost, localises"));
}

TEST(MissionSummaryTest, SaysWhatTheStoreLetGoOf) {
  MissionSummary summary = MakeSummary();
  EXPECT_EQ(FormatSummary(summary).find("let go"), std::string::npos);
  summary.local_maps[0].set_retired_keyframes(7);
  summary.local_maps[0].set_faded_map_points(1);
  summary.local_maps[1].set_retired_keyframes(2);
  EXPECT_THAT(FormatSummary(summary),
              HasSubstr("the store let go of 9 keyframes that others stand in for and 1 point "));
  EXPECT_EQ(ToJson(summary)["local_maps"][0]["retired_keyframes"], 7);
}

TEST(MissionSummaryTest, SaysWhichLocalMapsBecameParts) {
  MissionSummary summary = MakeSummary();
  EXPECT_EQ(FormatSummary(summary).find("became parts"), std::string::npos);
  summary.local_maps[0].add_joined_local_maps("missions/lab/localMaps/0000000000000007");
  summary.local_maps[0].add_joined_local_maps("missions/lab/localMaps/0000000000000008");
  EXPECT_THAT(FormatSummary(summary), HasSubstr("2 closed local maps became parts of others"));
  EXPECT_EQ(ToJson(summary)["local_maps"][0]["joined_local_maps"], 2);
}

// Its files are called so, too: of those that are gone nobody gets the number.
TEST(MissionSummaryTest, CallsLocalMapsByTheirNumbers) {
  MissionSummary summary = MakeSummary();
  summary.local_maps[0].set_number(2);
  summary.local_maps[1].set_number(1);
  summary.local_maps[2].set_number(6);
  for (const uint32_t number : {4u, 3u}) {
    summary.local_maps[0].add_joined_local_maps(MapName(10 + static_cast<int>(number)));
    summary.local_maps[0].add_joined_numbers(number);
  }
  AddOverlap(13, 2, v1::OVERLAP_VERDICT_ACCEPTED, 52, summary);
  const std::string text = FormatSummary(summary);
  EXPECT_THAT(text, AllOf(HasSubstr("\nalpha/2 "), HasSubstr(" alpha/3 to alpha/4\n"),
                          HasSubstr("\nalpha/6 "), HasSubstr("in the frame of alpha/6"),
                          HasSubstr("  alpha/2 and bravo/1, fused: 3 accepted")));
  const nlohmann::ordered_json json = ToJson(summary)["local_maps"];
  EXPECT_EQ(json[2]["short_name"], "alpha/6");
  EXPECT_EQ(json[0]["parts"].dump(), R"(["alpha/4","alpha/3"])");
}

// Overlaps name keyframes, which keep the names of the local maps that they were made in.
TEST(MissionSummaryTest, CountsOverlapsOfPartsWithTheirWholes) {
  MissionSummary summary = MakeSummary();
  summary.local_maps[0].add_joined_local_maps(MapName(7));
  AddOverlap(7, 2, v1::OVERLAP_VERDICT_ACCEPTED, 52, summary);
  AddOverlap(1, 7, v1::OVERLAP_VERDICT_ACCEPTED, 20, summary);
  EXPECT_THAT(FormatSummary(summary),
              AllOf(HasSubstr("  alpha/1 and bravo/1, fused: 3 accepted (up to 52 inliers); 1 "),
                    HasSubstr("  alpha/1, loops: 2 accepted (up to 60 inliers)\n")));
}

constexpr char kNothingShared[] = "no two keyframes share enough words";

void AddUncompared(int query, int against, uint64_t waiting, uint64_t failed,
                   MissionSummary& summary) {
  v1::UncomparedPair& pair = *summary.statistics.add_uncompared();
  pair.set_query(MapName(query));
  pair.set_against(MapName(against));
  pair.set_waiting(waiting);
  pair.set_failed(failed);
}

// Between bravo's first local map and alpha's second one nothing was found, because nobody looked.
TEST(MissionSummaryTest, NeverSpeaksOfWordsWhereNobodyLooked) {
  MissionSummary summary = MakeSummary();
  summary.mission.set_waiting_queries(12);
  summary.mission.set_worker_away_since_ns(1'700'000'000'000'000'000);
  summary.mission.set_worker_error("no fusion worker answers at w:1: Connection refused");
  AddUncompared(3, 2, 5, 0, summary);
  AddUncompared(2, 3, 7, 1, summary);
  AddUncompared(1, 1, 4, 0, summary);
  const std::string text = FormatSummary(summary);
  EXPECT_THAT(
      text, AllOf(HasSubstr("fusion waits for a worker"),
                  HasSubstr("12 look-ups waiting: no fusion worker takes requests since 2023-11-1"),
                  HasSubstr("(no fusion worker answers at w:1: Connection refused)"),
                  HasSubstr("bravo/1 and alpha/2, apart: 12 look-ups waiting for a fusion "
                            "worker; 1 look-up given up because fusion workers failed\n")));
  EXPECT_EQ(text.find(kNothingShared), std::string::npos) << text;
  const nlohmann::ordered_json json = ToJson(summary);
  EXPECT_EQ(json["mission"]["waiting_queries"], 12);
  for (const auto& pair : json["pairs"]) {
    if (pair["local_maps"].dump() == R"(["bravo/1","alpha/2"])") {
      EXPECT_EQ(pair["waiting"], 12);
    }
  }
}

TEST(MissionSummaryTest, NeverSpeaksOfWordsWhereNothingCouldBeLookedAt) {
  MissionSummary none = MakeSummary();
  none.mission.set_lacks_fusion_worker(true);
  none.mission.set_waiting_queries(3);
  AddUncompared(3, 2, 3, 0, none);
  EXPECT_THAT(FormatSummary(none), AllOf(HasSubstr("3 look-ups waiting: the store has no fusion"),
                                         ::testing::Not(HasSubstr(kNothingShared))));
  MissionSummary early = MakeSummary();
  early.local_maps[2].set_settled_keyframes(0);
  EXPECT_THAT(FormatSummary(early), AllOf(HasSubstr("too few keyframes to be compared yet"),
                                          ::testing::Not(HasSubstr(kNothingShared))));
  MissionSummary failed = MakeSummary();
  failed.statistics.set_failed_requests(9);
  EXPECT_THAT(FormatSummary(failed), AllOf(HasSubstr("9 requests of this mission failed"),
                                           ::testing::Not(HasSubstr(kNothingShared))));
}

TEST(MissionSummaryTest, HasTheSameAsJson) {
  const nlohmann::ordered_json json = ToJson(MakeSummary());
  EXPECT_EQ(json["mission"]["name"], "missions/lab");
  EXPECT_EQ(json["agents"].size(), 2u);
  EXPECT_EQ(json["agents"][0]["local_maps"].size(), 2u);
  EXPECT_EQ(json["agents"][0]["last_pose"]["position_in_island"][2], -2.0);
  EXPECT_EQ(json["agents"][0]["last_pose"]["in_global_frame"], false);
  EXPECT_FALSE(json["agents"][1].contains("last_pose"));
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
}  // namespace corbslam::services
