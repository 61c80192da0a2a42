#include "services/programs/robot/robot_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

// Makes a report in which every field has a value that no other has, and none its default.
RobotReport MakeWholeReport() {
  RobotReport report;
  report.name = "alpha";
  report.source = "kitti:/data/00";
  report.source_description = {{"layout", "kitti"}, {"frames", 4541}, {"baseline_m", 0.54}};
  report.warnings = {{"", "gaps", "3 gaps"}, {"", "nothing-tracked", "none of 7 frames"}};
  report.frames = 101;
  report.tracked = 102;
  report.dropped = 103;
  report.lost = 104;
  report.left_out = 105;
  report.pictures_s = 10.625;
  report.local_maps = 107;
  report.hand_overs = 135;
  report.brought_back = 137;
  report.far_recognised = 138;
  report.far_unreadable = 139;
  report.resumed_after_s = 0.144;
  report.why_not_resumed = "another camera";
  report.map_mb = 136.5;
  report.first_upload_s = 0.1;
  report.keyframes_held = 109;
  report.points_matched_percent = 11.0;
  report.shared_loops_closed = 111;
  report.places_told = 141;
  report.located_after_s = 0.142;
  report.loops_closed = 112;
  report.shared_relocalised = 143;
  report.relocalised = 136;
  report.keyframes = 113;
  report.map_points = 114;
  report.ate_m = 0.015;
  report.ate_from_frame_m = 0.016;
  report.ate_global_m = 0.017;
  report.told_ate_m = 0.018;
  report.told_ate_before_m = 0.019;
  report.told_jumps = 147;
  report.told_jumps_m = 0.148;
  report.told_largest_jump_m = 0.149;
  report.t_rel_percent = 0.7;
  report.r_rel_deg_per_100m = 0.3;
  report.tracking_ms = {20.5, 21.5, 1.0 / 3};
  report.latency_ms = {25.5, 26.5, 27.5};
  report.local_ba_ms = {30.5, 31.5, 32.5};
  report.local_ba_count = 121;
  report.peak_rss_mb = 122.5;
  report.cpu_s = 123.5;
  report.outbox = {124, 5'000'000'000, 126, 145, 127, 134};
  report.held_back = {128, 129, 130, 131};
  report.bytes_up = 6'000'000'000;
  report.bytes_down = 133;
  report.settings = {{"version_of_all", 146}};
  return report;
}

TEST(RobotReportTest, EveryFieldIsWrittenAndReadBack) {
  const RobotReport report = MakeWholeReport();
  // The report goes through text, as between two processes.
  const Json json = Json::parse(ToJson(report).dump(2));
  const absl::StatusOr<RobotReport> read = RobotReportFromJson(json);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, report);
  EXPECT_EQ(ToJson(*read).dump(), json.dump());
}

TEST(RobotReportTest, TheFieldsAboveAreAllThatThereAre) {
  const Json whole = ToJson(MakeWholeReport()).flatten();
  const Json empty = ToJson(RobotReport()).flatten();
  for (const auto& [place, value] : empty.items()) {
    // An object or a list of the whole report has other places there.
    if (place == "/source_description" || place == "/warnings" || place == "/settings") continue;
    ASSERT_TRUE(whole.contains(place)) << place;
    EXPECT_NE(whole[place], value) << place << " is not set in this test";
  }
  std::vector<std::string> seen;
  for (const auto& [place, value] : whole.items()) {
    EXPECT_THAT(seen, ::testing::Not(::testing::Contains(value.dump()))) << place;
    seen.push_back(value.dump());
  }
}

TEST(RobotReportTest, NamesOfFieldsStay) {
  const Json json = ToJson(MakeWholeReport());
  EXPECT_EQ(json["name"], "alpha");
  EXPECT_EQ(json["source_description"]["layout"], "kitti");
  EXPECT_EQ(json["frames"], 101);
  EXPECT_EQ(json["shared"]["keyframes_held"], 109);
  EXPECT_EQ(json["shared"]["points_matched_percent"], 11.0);
  EXPECT_EQ(json["shared"]["loops_closed"], 111);
  EXPECT_EQ(json["loops_closed"], 112);
  EXPECT_EQ(json["shared"]["relocalised"], 143);
  EXPECT_EQ(json["relocalised"], 136);
  EXPECT_EQ(json["tracking_ms"]["median"], 20.5);
  EXPECT_EQ(json["tracking_ms"]["mean"], 21.5);
  EXPECT_EQ(json["latency_ms"], (Json{{"median", 25.5}, {"mean", 26.5}, {"p99", 27.5}}));
  EXPECT_EQ(json["local_ba_ms"], 30.5);
  EXPECT_EQ(json["local_ba"], (Json{{"count", 121}, {"mean_ms", 31.5}, {"p99_ms", 32.5}}));
  EXPECT_EQ(json["outbox"], (Json{{"batches", 124},
                                  {"memory_bytes", 5'000'000'000},
                                  {"spool_bytes", 126},
                                  {"spool_syncs", 145},
                                  {"lost_local_maps", 127},
                                  {"refused_items", 134}}));
  EXPECT_EQ(json["held_back"],
            (Json{{"poses", 128}, {"keyframes", 129}, {"points", 130}, {"light_points", 131}}));
  EXPECT_EQ(json["warnings"][1], (Json{{"code", "nothing-tracked"}, {"text", "none of 7 frames"}}));
}

TEST(RobotReportTest, WhatIsNotKnownIsNullAndStaysSo) {
  const Json json = ToJson(RobotReport());
  for (const char* field :
       {"first_upload_s", "resumed_after_s", "ate_m", "ate_from_frame_m", "ate_global_m",
        "t_rel_percent", "r_rel_deg_per_100m", "peak_rss_mb", "cpu_s", "source_description"}) {
    EXPECT_TRUE(json.contains(field) && json[field].is_null()) << field;
  }
  const absl::StatusOr<RobotReport> read = RobotReportFromJson(json);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, RobotReport());
}

TEST(RobotReportTest, AFieldThatIsMissingOrOfAnotherKindIsNamed) {
  const Json whole = ToJson(MakeWholeReport());
  for (const auto& [key, value] : whole.items()) {
    Json missing = whole;
    missing.erase(key);
    const absl::Status status = RobotReportFromJson(missing).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << key;
    EXPECT_THAT(std::string(status.message()), HasSubstr("has no " + key));
    Json wrong = whole;
    wrong[key] = true;
    EXPECT_EQ(RobotReportFromJson(wrong).status().code(), absl::StatusCode::kDataLoss) << key;
  }
  for (const Json& not_a_report : {Json(nullptr), Json(3), Json::array(), Json("{}")}) {
    EXPECT_FALSE(RobotReportFromJson(not_a_report).ok()) << not_a_report;
  }
}

TEST(RobotReportTest, CountsAreNeitherCutNorWrapped) {
  for (const char* text : {"1.5", "-1", "4294967297", "1e3", "\"7\"", "null"}) {
    Json json = ToJson(MakeWholeReport());
    json["tracked"] = Json::parse(text);
    const absl::Status status = RobotReportFromJson(json).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("for tracked")) << text;
  }
}

TEST(RobotReportTest, TheLastLineSaysWhatCameOfIt) {
  RobotReport report;
  report.frames = 1800;
  report.tracked = 1790;
  report.dropped = 3;
  report.keyframes = 145;
  report.map_points = 9000;
  report.local_maps = 1;
  EXPECT_EQ(DescribeEnd(report),
            "done: 1790 of 1800 frames tracked, 3 dropped; 145 keyframes, 9000 points in 1 local "
            "map");
  report.local_maps = 2;
  report.outbox.batches = 4;
  report.warnings = {{"", "source-too-slow", "the source is too slow"}};
  EXPECT_EQ(DescribeEnd(report),
            "done: 1790 of 1800 frames tracked, 3 dropped; 145 keyframes, 9000 points in 2 local "
            "maps; 4 batches did not reach the store; source-too-slow");
  // The local map that is open from the start on is none yet.
  RobotReport nothing;
  nothing.local_maps = 1;
  EXPECT_THAT(DescribeEnd(nothing), ::testing::HasSubstr("0 keyframes, 0 points in 0 local maps"));
}

TEST(ComputeSpreadTest, HasKnownValues) {
  const Spread even = ComputeSpread({4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(even.median, 2.5);
  EXPECT_DOUBLE_EQ(even.mean, 2.5);
  EXPECT_DOUBLE_EQ(even.p99, 4);
  std::vector<double> hundred;
  for (int i = 1; i <= 100; ++i) hundred.push_back(i);
  EXPECT_DOUBLE_EQ(ComputeSpread(hundred).p99, 99);
  EXPECT_DOUBLE_EQ(ComputeSpread({}).median, 0);
}

}  // namespace
}  // namespace corbslam::services
