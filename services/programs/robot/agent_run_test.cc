#include "services/programs/robot/agent_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "services/programs/robot/testing/queued_stream.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::FramePose;
using client_agent::NoFrameYet;
using client_agent::PoseListener;
using client_agent::SourceFindings;
using client_agent::StreamEnd;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::TrajectoryPose;

namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// Notes what it is told, in order: stamps in seconds, and -1 for a new local map.
class NotingAgent : public Agent {
 public:
  std::vector<double> told;
  std::vector<size_t> samples;  // How many of an IMU came with each frame.
  TrackingResult result;        // What Track answers, but for the time.

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override {
    told.push_back(1e-9 * static_cast<double>(images.timestamp_ns));
    samples.push_back(images.imu.size());
    result.timestamp_ns = images.timestamp_ns;
    return result;
  }
  absl::Status UsePause() override { return absl::OkStatus(); }
  void BeginLocalMap() override { told.push_back(-1); }
  void Step() override {}
  absl::Status Finish(absl::Duration /*timeout*/) override { return absl::OkStatus(); }
  AgentStatus status;
  AgentStatus GetStatus() const override { return status; }
  AgentTimings GetTimings() const override { return {}; }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return {}; }
  Map CopyMap() const override { return {}; }
  std::optional<client_agent::NearMap> GetNearMap(
      const client_agent::NearMapLimits&) const override {
    return std::nullopt;
  }
};

class PlayStreamTest : public ::testing::Test {
 protected:
  absl::Status Play(Pace pace = Pace::kMax) {
    return PlayStream(stream_, agent_, pace, stop_, frames_,
                      [this](const TrackingResult& result, const FrameMoment& moment) {
                        heard_.push_back(1e-9 * static_cast<double>(result.timestamp_ns));
                        EXPECT_EQ(moment.dropped, frames_.dropped);
                      });
  }

  QueuedStream stream_;
  NotingAgent agent_;
  absl::Notification stop_;
  PlayedFrames frames_;
  std::vector<double> heard_;
};

TEST_F(PlayStreamTest, PlaysAStreamWithoutASizeUntilItEnds) {
  stream_.Put(NoFrameYet());
  for (size_t i = 0; i < 3; ++i) {
    stream_.PutFrame(i, static_cast<double>(i));
    stream_.Put(NoFrameYet());
  }
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  EXPECT_THAT(agent_.told, ElementsAre(0, 1, 2));
  EXPECT_EQ(heard_, agent_.told);
  EXPECT_EQ(frames_.played, 3u);
  EXPECT_EQ(frames_.dropped, 0u);
}

TEST_F(PlayStreamTest, AStreamThatFailsEndsWithItsStatusAfterTheFramesBefore) {
  stream_.PutFrame(0, 0);
  stream_.PutFrame(1, 1);
  stream_.Put(absl::DataLossError("frame 2: the camera was unplugged"));
  stream_.PutFrame(3, 3);
  EXPECT_EQ(Play(), absl::DataLossError("frame 2: the camera was unplugged"));
  EXPECT_THAT(agent_.told, ElementsAre(0, 1));
  EXPECT_EQ(frames_.played, 2u);
}

TEST_F(PlayStreamTest, AtTheSensorsPaceFramesWhoseTimeHasPassedAreDroppedAndCounted) {
  for (size_t i = 0; i < 3; ++i) stream_.PutFrame(i, 4);
  stream_.Put(absl::DataLossError("frame 3"));
  EXPECT_EQ(Play(Pace::kSensor), absl::DataLossError("frame 3"));
  EXPECT_THAT(agent_.told, SizeIs(1));
  EXPECT_EQ(frames_.played, 1u);
  EXPECT_EQ(frames_.dropped, 2u);
}

TEST_F(PlayStreamTest, WhatWasMeasuredBeforeAFrameThatIsLeftOutComesWithTheNext) {
  for (int64_t i = 0; i < 4; ++i) {
    const int64_t time_ns = i * 100'000'000;
    stream_.PutImuFrame(static_cast<size_t>(i), time_ns, {time_ns - 1, time_ns});
  }
  stream_.Put(StreamEnd());
  FrameRateLimit limit;
  limit.Set(5);
  EXPECT_TRUE(PlayStream(
                  stream_, agent_, Pace::kMax, stop_, frames_,
                  [](const TrackingResult&, const FrameMoment&) {}, &limit)
                  .ok());
  EXPECT_THAT(agent_.told, ElementsAre(0, 0.2));
  EXPECT_THAT(agent_.samples, ElementsAre(2u, 4u));
}

TEST_F(PlayStreamTest, AnotherDriveIsAnotherLocalMap) {
  stream_.PutFrame(0, 5, 0);
  stream_.PutFrame(1, 6, 0);
  stream_.PutFrame(2, 0, 1);
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  EXPECT_THAT(agent_.told, ElementsAre(5, 6, -1, 0));
}

TEST_F(PlayStreamTest, TellsTheStreamsListenerEachPose) {
  class Listener : public PoseListener {
   public:
    std::vector<FramePose> poses;
    void OnPose(const FramePose& pose) override { poses.push_back(pose); }
  } listener;
  stream_.listener = &listener;
  agent_.result.state = TrackingState::kTracking;
  agent_.result.local_map = {5};
  agent_.result.points_matched = 30;
  agent_.result.camera_from_local.translation = {1, 2, 3};
  stream_.PutFrame(0, 7);
  stream_.when_empty = [&] {
    if (listener.poses.size() == 2) return stream_.Put(StreamEnd());
    agent_.result.state = TrackingState::kLost;
    stream_.PutFrame(1, 8);
  };
  EXPECT_TRUE(Play().ok());
  ASSERT_THAT(listener.poses, SizeIs(2));
  EXPECT_EQ(listener.poses[0].timestamp_ns, 7'000'000'000);
  EXPECT_EQ(listener.poses[0].local_map.value, 5u);
  EXPECT_EQ(listener.poses[0].points_matched, 30);
  ASSERT_TRUE(listener.poses[0].local_from_camera.has_value());
  EXPECT_EQ(listener.poses[0].local_from_camera->translation.x(), -1);
  EXPECT_FALSE(listener.poses[0].is_lost);
  EXPECT_FALSE(listener.poses[1].local_from_camera.has_value());
  EXPECT_TRUE(listener.poses[1].is_lost);
}

TEST_F(PlayStreamTest, StopsWhileTheStreamIsSilent) {
  stream_.PutFrame(0, 0);
  stream_.when_empty = [this] { stop_.Notify(); };
  EXPECT_TRUE(Play().ok());
  EXPECT_EQ(frames_.played, 1u);
}

TEST_F(PlayStreamTest, CountsWhatTheStreamLeftOut) {
  stream_.left_out_frames = {2, "frame 1 is cut short"};
  stream_.PutFrame(0, 0);
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  EXPECT_EQ(frames_.left_out, 2u);
  const SourceFindings warnings = CollectWarnings({}, agent_, stream_, frames_);
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_EQ(warnings[0].code, "frames-left-out");
  EXPECT_EQ(warnings[1].code, "nothing-tracked");
  EXPECT_THAT(warnings[1].text, HasSubstr("corbslam rig check"));
  EXPECT_THAT(warnings[1].text, Not(HasSubstr("doctor")));
}

TEST_F(PlayStreamTest, SaysWhereLengthsAreNoMetres) {
  stream_.PutFrame(0, 0);
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  agent_.status.tracked = 1;
  agent_.status.without_metres = true;
  agent_.status.global_without_metres = true;
  SourceFindings warnings = CollectWarnings({}, agent_, stream_, frames_);
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_EQ(warnings[0].code, "without-metres");
  EXPECT_THAT(warnings[0].text, HasSubstr("--align sim3"));
  agent_.status.global_without_metres = false;
  EXPECT_THAT(CollectWarnings({}, agent_, stream_, frames_)[0].text, HasSubstr("is in metres"));
  agent_.status = AgentStatus();
  agent_.status.why_no_pose = client_agent::WhyNoPose::kLittleParallax;
  EXPECT_THAT(CollectWarnings({}, agent_, stream_, frames_)[0].text, HasSubstr("moved aside"));
}

// A stream that ends, or whose pictures were all left out, is no success; a robot that was stopped
// before its camera gave anything is.
TEST_F(PlayStreamTest, NoFrameAtAllIsNothingTracked) {
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  SourceFindings warnings = CollectWarnings({}, agent_, stream_, frames_);
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_EQ(warnings[0].code, "nothing-tracked");
  EXPECT_THAT(warnings[0].text, HasSubstr("no frame to track"));
  stream_.live = false;
  EXPECT_THAT(CollectWarnings({}, agent_, stream_, frames_)[0].text, HasSubstr("corbslam doctor"));
  stream_.live = true;
  frames_ = PlayedFrames();
  stop_.Notify();
  EXPECT_TRUE(Play().ok());
  EXPECT_THAT(CollectWarnings({}, agent_, stream_, frames_), SizeIs(0));
  stream_.left_out_frames = {79, "no counterpart in time"};
  warnings = CollectWarnings({}, agent_, stream_, frames_);
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_EQ(warnings[1].code, "nothing-tracked");
}

// Why nothing was tracked is said by the case.
TEST_F(PlayStreamTest, ARobotThatOnlyLocalisesIsToldWhatIsSo) {
  stream_.live = false;
  stream_.PutFrame(0, 0);
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  const auto text = [this](const RobotTask& task) {
    return CollectWarnings({}, agent_, stream_, frames_, task).back().text;
  };
  RobotTask task{.localise_only = true, .mission = "labb", .session = {}};
  task.session = absl::NotFoundError("there is no mission labb");
  EXPECT_THAT(text(task), AllOf(HasSubstr("there is no mission labb"), HasSubstr("--mission right"),
                                Not(HasSubstr("doctor"))));
  task.session = absl::UnavailableError("Connection refused");
  EXPECT_THAT(text(task), AllOf(HasSubstr("no session"), HasSubstr("Connection refused")));
  task.session = absl::OkStatus();
  EXPECT_THAT(text(task),
              AllOf(HasSubstr("nobody has mapped in mission labb"), Not(HasSubstr("doctor"))));
  task.shares_nearby = true;
  EXPECT_THAT(text(task), HasSubstr("did not recognise the place"));
  agent_.status.foreign_keyframes = 31;
  EXPECT_THAT(text(task), AllOf(HasSubstr("recognised nowhere in the 31 keyframes"),
                                HasSubstr("corbslam doctor")));
  agent_.status.why_no_pose = client_agent::WhyNoPose::kAnotherCamera;
  EXPECT_THAT(text(task),
              AllOf(HasSubstr("another camera than the rig's"), Not(HasSubstr("there is no map"))));
}

TEST_F(PlayStreamTest, ARobotThatResumedIsToldThatThePlaceWasNotRecognised) {
  stream_.PutFrame(0, 0);
  stream_.Put(StreamEnd());
  EXPECT_TRUE(Play().ok());
  agent_.status.keyframes = 12;
  const std::string text =
      CollectWarnings({}, agent_, stream_, frames_, {.resume = true, .mission = "", .session = {}})
          .back()
          .text;
  EXPECT_THAT(text, AllOf(HasSubstr("map of 12 keyframes that --resume took up"),
                          Not(HasSubstr("there is no map"))));
}

TEST_F(PlayStreamTest, WhatTheStreamFoundIsAmongTheWarnings) {
  stream_.found = {{client_agent::FindingLevel::kWarning, "pair-late", "the right camera is late"}};
  frames_.stopped = true;
  const SourceFindings warnings = CollectWarnings({}, agent_, stream_, frames_);
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_EQ(warnings[0].code, "pair-late");
}

}  // namespace
}  // namespace corbslam::services
