#include "services/tool/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

RunReport MakeReport() {
  RunReport report;
  report.robots.resize(2);
  report.robots[0].name = "alpha";
  report.robots[0].ate_m = 0.25;
  report.robots[0].t_rel_percent = 0.75;
  report.robots[0].r_rel_deg_per_100m = 0.125;
  report.robots[0].cpu_s = 12.5;
  report.robots[0].tracking_ms = {20, 22, 40};
  report.robots[0].pictures_s = 20;
  report.robots[1].name = "bravo";
  report.robots[1].pictures_s = 10;
  report.fused.islands = 1;
  report.fused.ate_m = 0.3;
  report.fused.ate_without_scale_m = 0.125;
  report.fused.scale = 0.998;
  report.merge_ms = {120.5};
  report.global_ba_ms.push_back({64, 10000, 12, 800});
  report.servers["map_store"] = {100, 3};
  return report;
}

TEST(ToJsonTest, KeepsTheInterface) {
  const nlohmann::ordered_json json = ToJson(MakeReport());
  EXPECT_EQ(json["robots"][0]["ate_m"], 0.25);
  EXPECT_TRUE(json["robots"][1]["ate_m"].is_null());
  EXPECT_EQ(json["robots"][0]["t_rel_percent"], 0.75);
  EXPECT_EQ(json["robots"][0]["r_rel_deg_per_100m"], 0.125);
  EXPECT_EQ(json["robots"][0]["cpu_s"], 12.5);
  for (const char* key : {"t_rel_percent", "r_rel_deg_per_100m", "cpu_s"}) {
    EXPECT_TRUE(json["robots"][1].contains(key)) << key;
    EXPECT_TRUE(json["robots"][1][key].is_null()) << key;
  }
  EXPECT_EQ(json["robots"][0]["tracking_ms"]["p99"], 40);
  // The report holds what the robot wrote.
  EXPECT_EQ(json["robots"][0].dump(), ToJson(MakeReport().robots[0]).dump());
  EXPECT_EQ(json["fused"]["islands"], 1);
  EXPECT_EQ(json["fused"]["ate_without_scale_m"], 0.125);
  EXPECT_EQ(json["fused"]["scale"], 0.998);
  EXPECT_EQ(json["merge_ms"][0], 120.5);
  EXPECT_EQ(json["global_ba_ms"][0]["map_points"], 10000);
  EXPECT_EQ(json["servers"]["map_store"]["cpu_s"], 3);
  for (const char* key : {"robots", "fused", "overlaps", "merge_ms", "global_ba_ms", "transfer",
                          "servers", "per_robot_minute", "wall_s", "version", "command"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  for (const char* key : {"name", "frames", "tracked", "dropped", "lost", "local_maps",
                          "first_upload_s", "shared", "keyframes", "map_points", "ate_m",
                          "tracking_ms", "local_ba_ms", "peak_rss_mb", "bytes_up", "bytes_down"}) {
    EXPECT_TRUE(json["robots"][0].contains(key)) << key;
  }
  for (const char* key : {"keyframes_held", "points_matched_percent", "loops_closed"}) {
    EXPECT_TRUE(json["robots"][0]["shared"].contains(key)) << key;
  }
  for (const char* key : {"islands", "robots", "keyframes", "map_points", "ate_m", "t_rel_percent",
                          "r_rel_deg_per_100m"}) {
    EXPECT_TRUE(json["fused"].contains(key)) << key;
  }
  for (const char* key :
       {"full_keyframes", "full_map_points", "light_keyframes", "light_map_points"}) {
    for (const char* part : {"count", "bytes", "ms"}) {
      EXPECT_TRUE(json["transfer"][key].contains(part)) << key << part;
    }
  }
}

TEST(ToJsonTest, SaysWhatAMinuteOfOneRobotCosts) {
  RunReport report = MakeReport();
  nlohmann::ordered_json cost = ToJson(report)["per_robot_minute"];
  EXPECT_DOUBLE_EQ(cost["pictures_s"], 30);
  EXPECT_TRUE(cost["robot_cpu_s"].is_null()) << "bravo's is not known";
  EXPECT_DOUBLE_EQ(cost["servers_cpu_s"]["map_store"], 6);
  EXPECT_DOUBLE_EQ(cost["global_adjustments"], 2);
  report.robots[1].cpu_s = 2.5;
  EXPECT_DOUBLE_EQ(ToJson(report)["per_robot_minute"]["robot_cpu_s"], 30);
  report.servers.clear();
  report.global_ba_ms.clear();
  cost = ToJson(report)["per_robot_minute"];
  EXPECT_TRUE(cost["servers_cpu_s"].is_object());
  EXPECT_TRUE(cost["servers_cpu_s"].empty());
  EXPECT_DOUBLE_EQ(cost["global_adjustments"], 0);
  // The robots have no pictures.
  for (RobotReport& robot : report.robots) robot.pictures_s = 0;
  EXPECT_TRUE(ToJson(report)["per_robot_minute"].is_null());
  report.robots.clear();
  EXPECT_TRUE(ToJson(report)["per_robot_minute"].is_null());
}

TEST(ToMarkdownTest, SaysWhatAMinuteOfOneRobotCosts) {
  RunReport report = MakeReport();
  EXPECT_THAT(ToMarkdown(report), HasSubstr("A minute of one robot's pictures: map_store 6.0 s of "
                                            "processor, 2.0 global adjustments\n"));
  report.robots[1].cpu_s = 2.5;
  EXPECT_THAT(ToMarkdown(report), HasSubstr("pictures: robot 30.0 s of processor, map_store"));
  report.robots.clear();
  EXPECT_THAT(ToMarkdown(report), Not(HasSubstr("A minute of")));
}

TEST(ToMarkdownTest, ShowsTheFigures) {
  const std::string text = ToMarkdown(MakeReport());
  EXPECT_THAT(text, HasSubstr("| alpha |"));
  EXPECT_THAT(text, HasSubstr("| 0.2500 | - | - | 0, 0.000 | 0.75 / 0.12 |"));
  EXPECT_THAT(text, HasSubstr("| - | 12.5 |"));
  EXPECT_THAT(text, HasSubstr("| 0.3000 | - | 0.1250 (0.99800) |"));
  EXPECT_THAT(text, HasSubstr("64 keyframes, 10000 points, 12 iterations, 800 ms"));
}

}  // namespace
}  // namespace corbslam::services
