#include "services/tool/report/report_company.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

RobotReport MakeRobot(const std::string& name, double ate_m, int tracked) {
  RobotReport robot;
  robot.name = name;
  robot.frames = 100;
  robot.tracked = tracked;
  robot.lost = 100 - tracked;
  robot.ate_m = ate_m;
  robot.ate_global_m = ate_m;
  return robot;
}

// Company helps alpha, and makes bravo worse.
RunReport MakeReport() {
  RunReport report;
  report.pace = "max";
  report.robots = {MakeRobot("alpha", 0.01, 100), MakeRobot("bravo", 0.03, 98)};
  report.robots[0].ate_global_m = 0.012;
  report.robots[0].told_ate_m = 0.011;
  report.robots[0].keyframes_held = 80;
  report.robots[0].points_matched_percent = 45.125;
  report.robots[0].shared_loops_closed = 1;
  report.robots[0].shared_relocalised = 2;
  report.robots[0].relocalised = 3;
  report.fused.ate_m = 0.02;
  report.company.emplace();
  report.company->alone = {MakeRobot("alpha", 0.04, 90), MakeRobot("bravo", 0.02, 98)};
  report.company->alone[0].told_ate_m = 0.013;
  report.company->fused_ate_alone_m = 0.05;
  report.company->wall_s = 12.5;
  return report;
}

TEST(CompanyToJsonTest, HoldsBothRunsOfEachRobot) {
  const Json company = ToJson(MakeReport())["company"];
  ASSERT_EQ(company["robots"].size(), 2u);
  const Json& alpha = company["robots"][0];
  EXPECT_EQ(alpha["name"], "alpha");
  EXPECT_EQ(alpha["ate_m"], (Json{{"with", 0.01}, {"without", 0.04}}));
  EXPECT_EQ(alpha["ate_global_m"], (Json{{"with", 0.012}, {"without", 0.04}}));
  EXPECT_EQ(alpha["told_ate_m"], (Json{{"with", 0.011}, {"without", 0.013}}));
  EXPECT_EQ(alpha["told_ate_before_m"], (Json{{"with", nullptr}, {"without", nullptr}}));
  EXPECT_EQ(alpha["tracked"], (Json{{"with", 100}, {"without", 90}}));
  EXPECT_EQ(alpha["lost"], (Json{{"with", 0}, {"without", 10}}));
  EXPECT_EQ(alpha["relocalised"], (Json{{"with", 3}, {"without", 0}}));
  EXPECT_EQ(alpha["others"], (Json{{"keyframes_held", 80},
                                   {"points_matched_percent", 45.125},
                                   {"loops_closed", 1},
                                   {"relocalised", 2}}));
  for (const char* key :
       {"ate_from_frame_m", "t_rel_percent", "frames", "local_maps", "loops_closed"}) {
    EXPECT_TRUE(alpha.contains(key)) << key;
  }
  EXPECT_EQ(company["fused_ate_m"], (Json{{"with", 0.02}, {"without", 0.05}}));
  EXPECT_EQ(company["wall_s"], 12.5);
}

TEST(CompanyToJsonTest, IsNullWhereNobodyPlayedAlone) {
  const Json json = ToJson(RunReport());
  ASSERT_TRUE(json.contains("company"));
  EXPECT_TRUE(json["company"].is_null());
  EXPECT_THAT(ToMarkdown(RunReport()), Not(HasSubstr("company")));
}

TEST(CompanyTableTest, HasARowForEachRobotAndOneForAll) {
  const ReportTable table = CompanyTable(MakeReport());
  ASSERT_EQ(table.rows.size(), 3u);
  for (const std::vector<std::string>& row : table.rows) {
    EXPECT_EQ(row.size(), table.columns.size());
  }
  EXPECT_EQ(table.rows[0][1], "0.0120 / 0.0400");
  EXPECT_EQ(table.rows[0][2], "0.0110 / 0.0130");
  EXPECT_EQ(table.rows[0][3], "0.0100 / 0.0400");
  EXPECT_EQ(table.rows[0][6], "45.1 %");
  EXPECT_EQ(table.rows[2][1], "0.0200 / 0.0500");
}

TEST(CompanyLinesTest, SayPlainlyWhatWasGainedAndWhatWasNot) {
  RunReport report = MakeReport();
  report.pace = "step";
  report.robots[1].points_matched_percent = 12;
  report.company->alone[0].local_maps = 1;
  report.company->alone[0].ate_m = 0.0444;
  const std::vector<std::string> lines = CompanyLines(report);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[0],
              AllOf(HasSubstr("alpha: 0.0120 m in the global frame with company, "
                              "0.0400 m alone (0.0444 m in its own map, without any "
                              "server), 70 % less"),
                    HasSubstr("as told when each frame came 0.0110 m and 0.0130 m"),
                    HasSubstr("10 frames more tracked"), HasSubstr("others made 45.1 %")));
  EXPECT_THAT(lines[1],
              AllOf(HasSubstr("bravo: 0.0300 m in the global frame with company, 0.0200 m "
                              "alone, 50 % more: company took accuracy"),
                    HasSubstr("nothing of others came to it"), Not(HasSubstr("frames")),
                    Not(HasSubstr("as told"))));
  EXPECT_THAT(lines[2], HasSubstr("repeats to the bit"));
}

TEST(CompanyLinesTest, CreditNobodyWithWhatIsNotTheirs) {
  const std::vector<std::string> lines = CompanyLines(MakeReport());
  EXPECT_THAT(lines[0], AllOf(HasSubstr("which one run of each can't tell from chance"),
                              Not(HasSubstr("% less"))));
  EXPECT_THAT(lines[1], HasSubstr("though it used nothing that others made"));
  EXPECT_THAT(lines[2], HasSubstr("One run each"));
}

// Less than is printed is nothing.
TEST(CompanyLinesTest, CreditNobodyWithWhatIsTooLittleToBeSeen) {
  RunReport report = MakeReport();
  report.pace = "step";
  report.robots[0].shared_loops_closed = report.robots[0].shared_relocalised = 0;
  report.robots[0].points_matched_percent = 0.04;
  EXPECT_THAT(CompanyLines(report)[0],
              AllOf(HasSubstr("though it used nothing that others made"), Not(HasSubstr("% less")),
                    HasSubstr("others made 0.0 %")));
  report.robots[0].points_matched_percent = 1;
  report.robots[0].ate_global_m = 0.0399;
  EXPECT_THAT(CompanyLines(report)[0], HasSubstr("alone: company gave no accuracy"));
}

TEST(CompanyLinesTest, TellEqualAndUnknownErrors) {
  RunReport report = MakeReport();
  report.company->alone[0].ate_global_m = 0.01204;
  report.company->alone[1].ate_global_m.reset();
  const std::vector<std::string> lines = CompanyLines(report);
  EXPECT_THAT(lines[0], HasSubstr("alpha: as accurate alone, 0.0120 m in the global frame"));
  EXPECT_THAT(lines[1], HasSubstr("bravo: its accuracy in the global frame is not known both"));
}

TEST(CompanyTest, StandsInTheTablesForPeople) {
  EXPECT_THAT(ToMarkdown(MakeReport()),
              AllOf(HasSubstr("## What company gave"), HasSubstr("| 0.0100 / 0.0400 |"),
                    HasSubstr("* bravo: 0.0300 m in the global frame")));
}

}  // namespace
}  // namespace corbslam::services
