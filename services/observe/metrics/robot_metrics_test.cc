#include "services/observe/metrics/robot_metrics.h"

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "services/observe/metrics/testing/metric_values.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

using testing::SumOf;
using testing::ValueOf;

class RobotMetricsTest : public ::testing::Test {
 protected:
  void Track(TrackingState state, bool made_keyframe = false) {
    TrackingResult result;
    result.state = state;
    result.made_keyframe = made_keyframe;
    metrics_.OnTracked(result, absl::Milliseconds(30));
  }
  std::optional<double> Value(const std::string& name, const testing::LabelMap& labels = {}) {
    return ValueOf(registry_.Collect(), name, labels);
  }

  prometheus::Registry registry_;
  RobotMetrics metrics_{registry_};
};

TEST_F(RobotMetricsTest, FramesAreCountedByHowTheyEnded) {
  EXPECT_EQ(Value("corbslam_robot_tracking_state", {{"state", "not_initialised"}}), 1);
  Track(TrackingState::kTracking, true);
  Track(TrackingState::kTracking);
  Track(TrackingState::kLost);
  EXPECT_EQ(Value("corbslam_robot_frames_total", {{"state", "tracking"}}), 2);
  EXPECT_EQ(Value("corbslam_robot_frames_total", {{"state", "lost"}}), 1);
  EXPECT_EQ(Value("corbslam_robot_frames_total", {{"state", "not_initialised"}}), 0);
  EXPECT_EQ(Value("corbslam_robot_keyframes_made_total"), 1);
  EXPECT_EQ(Value("corbslam_robot_tracking_state", {{"state", "lost"}}), 1);
  EXPECT_EQ(Value("corbslam_robot_tracking_state", {{"state", "tracking"}}), 0);
  EXPECT_EQ(Value("corbslam_robot_tracking_state", {{"state", "not_initialised"}}), 0);
  EXPECT_EQ(Value("corbslam_robot_frame_duration_seconds"), 3);
  EXPECT_NEAR(*SumOf(registry_.Collect(), "corbslam_robot_frame_duration_seconds"), 0.09, 1e-9);
}

TEST_F(RobotMetricsTest, DroppedFramesAreToldAsASum) {
  metrics_.SetDropped(3);
  metrics_.SetDropped(3);
  metrics_.SetDropped(5);
  EXPECT_EQ(Value("corbslam_robot_frames_dropped_total"), 5);
}

TEST_F(RobotMetricsTest, OnlySessionsAfterTheFirstAreReconnects) {
  metrics_.OnOpening();
  metrics_.OnClosed(absl::UnavailableError("no store yet"));
  metrics_.OnOpening();
  metrics_.OnOpened();
  EXPECT_EQ(Value("corbslam_robot_connected"), 1);
  EXPECT_EQ(Value("corbslam_robot_reconnects_total"), 0);
  metrics_.OnClosed(absl::UnavailableError("cut"));
  EXPECT_EQ(Value("corbslam_robot_connected"), 0);
  metrics_.OnOpening();
  metrics_.OnOpened();
  EXPECT_EQ(Value("corbslam_robot_reconnects_total"), 1);
  EXPECT_EQ(Value("corbslam_robot_session_attempts_total"), 3);
}

TEST_F(RobotMetricsTest, EachAcknowledgedBatchIsObserved) {
  MapUpdateBatch batch;
  batch.local_map = {7};
  for (batch.number = 1; batch.number <= 3; ++batch.number) {
    metrics_.OnSent(batch, absl::Now() - absl::Seconds(2));
  }
  metrics_.OnAcknowledged({{7}, 2});
  const std::string name = "corbslam_robot_acknowledgement_duration_seconds";
  EXPECT_EQ(Value(name), 2);
  EXPECT_NEAR(*SumOf(registry_.Collect(), name), 4, 1);
}

}  // namespace
}  // namespace corbslam::services
