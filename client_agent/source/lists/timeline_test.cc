#include "client_agent/source/lists/timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Makes times in milliseconds, in lines 1, 2, ...
std::vector<ListedTime> Lines(const std::vector<int64_t>& times_ms) {
  std::vector<ListedTime> times;
  for (const int64_t time_ms : times_ms) {
    times.push_back({time_ms * 1'000'000, static_cast<int>(times.size()) + 1});
  }
  return times;
}

std::vector<std::string> CodesOf(const SourceFindings& findings) {
  std::vector<std::string> codes;
  for (const SourceFinding& finding : findings) codes.push_back(finding.code);
  return codes;
}

TEST(BuildTimelineTest, KeepsTimesThatGrow) {
  const auto timeline = BuildTimeline("times.txt", Lines({0, 100, 200, 1500}));
  ASSERT_TRUE(timeline.ok()) << timeline.status();
  EXPECT_THAT(timeline->kept, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(timeline->drive, ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(timeline->remarks.findings, IsEmpty());
}

TEST(BuildTimelineTest, BeginsADriveWhereTimeJumpsBack) {
  const auto timeline = BuildTimeline("times.txt", Lines({5000, 5100, 100, 200, 0 + 300}));
  ASSERT_TRUE(timeline.ok()) << timeline.status();
  EXPECT_THAT(timeline->drive, ElementsAre(0, 0, 1, 1, 1));
  EXPECT_THAT(CodesOf(timeline->remarks.findings), ElementsAre("times-jump-back"));
  EXPECT_THAT(timeline->remarks.findings[0].text,
              HasSubstr("times.txt:3: the time jumps back from 5.100000000 s to 0.100000000 s"));
}

TEST(BuildTimelineTest, LeavesOutAFewThatAreOutOfOrder) {
  std::vector<int64_t> times_ms;
  for (int64_t i = 0; i < 20; ++i) times_ms.push_back(100 * i);
  std::swap(times_ms[7], times_ms[8]);
  const auto timeline = BuildTimeline("times.txt", Lines(times_ms));
  ASSERT_TRUE(timeline.ok()) << timeline.status();
  EXPECT_EQ(timeline->kept.size(), 19u);
  EXPECT_THAT(CodesOf(timeline->remarks.findings), ElementsAre("times-out-of-order"));
  EXPECT_THAT(timeline->remarks.left_out, ElementsAre(HasSubstr("1 of 20 times do not grow")));
}

struct Refused {
  std::vector<int64_t> times_ms;
  const char* says;
};
class RefusedTimesTest : public ::testing::TestWithParam<Refused> {};

TEST_P(RefusedTimesTest, AreNamedByLine) {
  const absl::Status status = BuildTimeline("times.txt", Lines(GetParam().times_ms)).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedTimesTest,
    ::testing::Values(Refused{{100, 200, 200, 300},
                              "times.txt:3: the time 0.200000000 s stands in "
                              "line 2 too"},
                      Refused{{0, 0, 0}, "times.txt:2"},
                      Refused{{-100, 0}, "times.txt:1: the time -0.100000000 s is negative"},
                      Refused{{900, 800, 700, 600}, "put the list in the order of time"}),
    testing::NamedBy(&Refused::says));

std::vector<int64_t> Regular(size_t count, int64_t step_ns) {
  std::vector<int64_t> times_ns;
  for (size_t i = 0; i < count; ++i) times_ns.push_back(static_cast<int64_t>(i) * step_ns);
  return times_ns;
}

TEST(MeasureTimesTest, TellsRateAndGaps) {
  std::vector<int64_t> times_ns = Regular(50, 100'000'000);
  for (size_t i = 30; i < times_ns.size(); ++i) times_ns[i] += 7'000'000'000;
  SourceFindings findings;
  const auto statistics = MeasureTimes("times.txt", times_ns, findings);
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_NEAR(statistics->rate_hz, 10, 1e-9);
  EXPECT_NEAR(statistics->duration_s, 11.9, 1e-9);
  EXPECT_EQ(statistics->gaps, 1u);
  EXPECT_NEAR(statistics->longest_gap_s, 7.1, 1e-9);
  EXPECT_EQ(statistics->longest_gap_frame, 30u);
  EXPECT_THAT(CodesOf(findings), ElementsAre("times-gap"));
}

// A picture a second, and two places where there was none for 5 to 7 s.
TEST(MeasureTimesTest, TellsLongGapsOfASlowSequence) {
  std::vector<int64_t> times_ns = Regular(50, 1'000'000'000);
  for (size_t i = 20; i < times_ns.size(); ++i) times_ns[i] += 4'500'000'000;
  for (size_t i = 40; i < times_ns.size(); ++i) times_ns[i] += 6'000'000'000;
  SourceFindings findings;
  const auto statistics = MeasureTimes("times.txt", times_ns, findings);
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_EQ(statistics->gaps, 2u);
  EXPECT_NEAR(statistics->longest_gap_s, 7, 1e-9);
  EXPECT_EQ(statistics->longest_gap_frame, 40u);
  EXPECT_THAT(CodesOf(findings), ElementsAre("times-gap"));
}

struct Unit {
  int64_t step_ns;
  bool refused;
  size_t warnings;
};
class TimeUnitTest : public ::testing::TestWithParam<Unit> {};

TEST_P(TimeUnitTest, IsJudgedByTheRate) {
  SourceFindings findings;
  const auto statistics = MeasureTimes("times.txt", Regular(20, GetParam().step_ns), findings);
  EXPECT_EQ(!statistics.ok(), GetParam().refused);
  EXPECT_EQ(findings.size(), GetParam().warnings);
  if (!statistics.ok()) {
    EXPECT_THAT(std::string(statistics.status().message()), HasSubstr("in another unit"));
  }
}

INSTANTIATE_TEST_SUITE_P(All, TimeUnitTest,
                         ::testing::Values(Unit{33'333'333, false, 0},       // 30 Hz.
                                           Unit{1'000'000'000, false, 0},    // A frame a second.
                                           Unit{5'000'000, false, 0},        // 200 Hz.
                                           Unit{1'000'000, false, 1},        // 1,000 Hz.
                                           Unit{10'000'000'000, false, 1},   // Every 10 s.
                                           Unit{50'000, true, 0},            // us for ns.
                                           Unit{100'000'000'000, true, 0}),  // ms for s.
                         [](const auto& info) { return absl::StrCat(info.param.step_ns, "_ns"); });

TEST(MeasureTimesTest, SaysNothingOfASingleFrame) {
  SourceFindings findings;
  EXPECT_TRUE(MeasureTimes("times.txt", {5}, findings).ok());
  EXPECT_THAT(findings, IsEmpty());
}

}  // namespace
}  // namespace corbslam::client_agent
