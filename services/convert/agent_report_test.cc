#include "services/convert/agent_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

AgentReport MakeReport() {
  return {.activity = AgentActivity::kWaiting,
          .frames = 10,
          .tracked = 7,
          .lost = 2,
          .dropped = 3,
          .newest_timestamp_ns = int64_t{1} << 62,
          .newest_frame_age_s = 2.5,
          .contradictions = {{LocalMapId{7}, 1.014, 0.001},
                             {LocalMapId{8}, 0.98, 0},
                             {LocalMapId{9}, 1, 0, MapBend{4.5, 0.13, 0.012}}}};
}

TEST(AgentReportTest, AllOfItComesBack) {
  for (const AgentActivity activity :
       {AgentActivity::kUnknown, AgentActivity::kInitialising, AgentActivity::kTracking,
        AgentActivity::kLost, AgentActivity::kWaiting, AgentActivity::kFinished}) {
    AgentReport report = MakeReport();
    report.activity = activity;
    v1::AgentReport proto;
    ToProto(report, &proto);
    const auto back = FromProto(proto);
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(*back, report);
  }
}

TEST(AgentReportTest, WhatIsImpossibleIsRefusedByItsField) {
  v1::AgentReport proto;
  for (const int64_t time_ns : {int64_t{-1}, (int64_t{1} << 62) + 1}) {
    proto.set_newest_timestamp_ns(time_ns);
    EXPECT_THAT(std::string(FromProto(proto).status().message()),
                HasSubstr("report.newest_timestamp_ns is"));
  }
  proto.Clear();
  for (const double age_s :
       {-0.1, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    proto.set_newest_frame_age_s(age_s);
    const absl::Status status = FromProto(proto).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("report.newest_frame_age_s is"));
  }
}

TEST(AgentReportTest, AScaleIsPositiveAndItsDeviationIsNotNegative) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double scale : {0.0, -1.0, kInfinity, kNaN}) {
    v1::AgentReport proto;
    proto.add_contradictions()->set_scale(scale);
    EXPECT_THAT(std::string(FromProto(proto).status().message()),
                HasSubstr("report.contradictions.scale is"));
  }
  for (const double sigma : {-0.1, kInfinity, kNaN}) {
    v1::AgentReport proto;
    proto.add_contradictions()->set_scale(1);
    proto.mutable_contradictions(0)->set_scale_sigma(sigma);
    EXPECT_THAT(std::string(FromProto(proto).status().message()),
                HasSubstr("report.contradictions.scale_sigma is"));
  }
  for (const double shift_m : {-0.1, kInfinity, kNaN}) {
    v1::AgentReport proto;
    proto.add_contradictions()->set_scale(1);
    proto.mutable_contradictions(0)->mutable_bend()->set_shift_m(shift_m);
    EXPECT_THAT(std::string(FromProto(proto).status().message()),
                HasSubstr("report.contradictions.bend.shift_m is"));
  }
  v1::AgentReport many;
  for (int i = 0; i < 101; ++i) many.add_contradictions()->set_scale(1);
  EXPECT_TRUE(absl::IsInvalidArgument(FromProto(many).status()));
}

TEST(AgentReportTest, AnActivityOfANewerVersionIsNotKnown) {
  v1::AgentReport proto;
  proto.set_activity(static_cast<v1::AgentActivity>(77));
  EXPECT_EQ(FromProto(proto)->activity, AgentActivity::kUnknown);
}

}  // namespace
}  // namespace corbslam::services
