#include "services/observe/tracing/robot_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/observe/tracing/testing/read_trace.h"

namespace corbslam::services {

using client_agent::TrackingResult;

namespace {

using ::testing::UnorderedElementsAre;

constexpr LocalMapId kMap{5};

std::shared_ptr<const KeyframePayload> MakePayload(KeyframeId id, int64_t timestamp_ns) {
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = id;
  payload->timestamp_ns = timestamp_ns;
  return payload;
}

// Returns a path that only the running test uses.
std::string TracePath() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return absl::StrCat(::testing::TempDir(), "/", test->test_suite_name(), "_", test->name());
}

class RobotTraceTest : public ::testing::Test {
 protected:
  RobotTraceTest() : path_(TracePath()) {
    file_ = *TraceFile::Open(path_, "client_agent lab/alpha");
    trace_ = std::make_unique<RobotTrace>(file_.get(), "lab", "alpha");
  }

  void Track(int64_t timestamp_ns, bool made_keyframe) {
    trace_->OnFrame(timestamp_ns);
    TrackingResult result;
    result.timestamp_ns = timestamp_ns;
    result.made_keyframe = made_keyframe;
    trace_->OnTracked(result, absl::ZeroDuration());
  }

  MapUpdateBatch MakeBatch(uint64_t number, KeyframeId id, int64_t timestamp_ns) {
    MapUpdateBatch batch;
    batch.local_map = kMap;
    batch.number = number;
    batch.full_keyframes.push_back({MakePayload(id, timestamp_ns), {}, {}});
    return batch;
  }

  std::map<std::string, std::set<std::string>> Ways() {
    file_.reset();
    return testing::WaysOf(*testing::ReadTrace(path_));
  }

  const std::string path_;
  std::unique_ptr<TraceFile> file_;
  std::unique_ptr<RobotTrace> trace_;
};

TEST_F(RobotTraceTest, FollowsAKeyframeFromTheCameraToItsGlobalPose) {
  const KeyframeId made{kMap, 0};
  const KeyframeId others{{6}, 3};
  Track(100, true);
  Track(133, false);
  trace_->OnSent(MakeBatch(1, made, 100), absl::Now());
  trace_->OnAcknowledged({kMap, 1});
  SharedUpdate update;
  update.keyframes.push_back({MakePayload(others, 7), {}, {}, {}});
  update.own_keyframes.push_back({made, {}, {}});
  trace_->OnShared(update);
  auto ways = Ways();
  EXPECT_THAT(ways[TraceId(made)],
              UnorderedElementsAre(kCaptured, kSent, kAcknowledged, kGlobalPose));
  EXPECT_THAT(ways[TraceId(others)], UnorderedElementsAre(kArrived));
  EXPECT_EQ(ways.size(), 2u);
}

TEST_F(RobotTraceTest, WhatAnEarlierProcessCapturedHasNoSuchEvent) {
  const KeyframeId spooled{kMap, 0};
  Track(100, false);
  trace_->OnSent(MakeBatch(1, spooled, 100), absl::Now());
  EXPECT_THAT(Ways()[TraceId(spooled)], UnorderedElementsAre(kSent));
}

}  // namespace
}  // namespace corbslam::services
