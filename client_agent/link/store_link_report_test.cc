// Tests what the link tells the map store of the robot itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"

namespace corbslam::client_agent {
namespace {

class StoreLinkReportTest : public ::testing::Test {
 protected:
  StoreLinkReportTest() { uplink_.capabilities.takes_reports = true; }

  void MakeLink() {
    StoreLinkOptions options;
    options.mission = "m";
    options.agent = "alpha";
    options.min_backoff = options.max_backoff = absl::ZeroDuration();
    options.clock = [this] { return now_; };
    if (watches_activity_) options.report = [this] { return report_; };
    link_ = std::make_unique<StoreLink>(options, &uplink_,
                                        [](const auto&) { return std::make_shared<Words>(); });
    link_->BeginLocalMap(map_, jobs_);
  }
  // Returns how many reports there were after a second more.
  size_t StepSecond() {
    now_ += absl::Seconds(1);
    link_->Step();
    return uplink_.reports.size();
  }

  FakeUplink uplink_;
  FakeMapJobs jobs_;
  GuardedMap map_{LocalMapId{1}};
  absl::Time now_ = absl::UnixEpoch() + absl::Hours(1);
  bool watches_activity_ = true;
  AgentReport report_{.activity = AgentActivity::kTracking};
  std::unique_ptr<StoreLink> link_;
};

TEST_F(StoreLinkReportTest, GoUpWhenTheActivityChangesAndEachFourSeconds) {
  MakeLink();
  link_->Step();
  EXPECT_EQ(uplink_.reports.size(), 1u);
  report_.frames = 30;
  EXPECT_EQ(StepSecond(), 1u);
  report_.activity = AgentActivity::kLost;
  EXPECT_EQ(StepSecond(), 2u);
  EXPECT_EQ(uplink_.reports.back().frames, 30u);
  EXPECT_EQ(StepSecond(), 2u);
  EXPECT_EQ(StepSecond(), 2u);
  EXPECT_EQ(StepSecond(), 2u);
  EXPECT_EQ(StepSecond(), 3u);
  // A new session's store may be another process.
  uplink_.Break(absl::UnavailableError("the store starts anew"));
  EXPECT_EQ(StepSecond(), 4u);
}

TEST_F(StoreLinkReportTest, AnOlderStoreIsSentNone) {
  uplink_.capabilities.takes_reports = false;
  MakeLink();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(StepSecond(), 0u);
}

TEST_F(StoreLinkReportTest, TheEndIsToldBeforeTheLinkEnds) {
  MakeLink();
  link_->Step();
  report_.activity = AgentActivity::kFinished;
  EXPECT_TRUE(link_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(uplink_.reports.back().activity, AgentActivity::kFinished);
}

TEST_F(StoreLinkReportTest, WhatIsLeftOutIsToldAtOnceAndWithEachReport) {
  MakeLink();
  link_->Step();
  EXPECT_TRUE(uplink_.reports.back().contradictions.empty());
  const MapContradiction found{LocalMapId{9}, 1.014, 0.001};
  link_->LeaveOut(found);
  link_->LeaveOut({LocalMapId{9}, 1.013, 0.001});
  EXPECT_EQ(StepSecond(), 2u);
  EXPECT_THAT(uplink_.reports.back().contradictions, ::testing::ElementsAre(found));
  report_.activity = AgentActivity::kLost;
  EXPECT_EQ(StepSecond(), 3u);
  EXPECT_THAT(uplink_.reports.back().contradictions, ::testing::ElementsAre(found));
}

TEST_F(StoreLinkReportTest, WhoWatchesNoActivityTellsWhatIsLeftOut) {
  watches_activity_ = false;
  MakeLink();
  EXPECT_EQ(StepSecond(), 0u);
  link_->LeaveOut({LocalMapId{9}, 1.014, 0.001});
  EXPECT_EQ(StepSecond(), 1u);
}

TEST_F(StoreLinkReportTest, WhatIsLeftOutIsLeftOutOfTheNextLocalMapToo) {
  MakeLink();
  link_->LeaveOut({LocalMapId{9}, 1.014, 0.001});
  GuardedMap next{LocalMapId{2}};
  FakeMapJobs jobs;
  link_->BeginLocalMap(next, jobs);
  EXPECT_EQ(jobs.size(), 1u);
}

}  // namespace
}  // namespace corbslam::client_agent
