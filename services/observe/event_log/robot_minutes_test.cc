#include "services/observe/event_log/robot_minutes.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::TrajectoryPose;

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TrackingResult Result(TrackingState state, int points) {
  TrackingResult result;
  result.state = state;
  result.points_matched = points;
  return result;
}

TEST(FrameTallyTest, CountsSinceTheLastCall) {
  FrameTally tally;
  for (const int points : {10, 300, 20}) {
    tally.OnTracked(Result(TrackingState::kTracking, points), absl::ZeroDuration());
  }
  tally.OnTracked(Result(TrackingState::kLost, 0), absl::ZeroDuration());
  tally.SetDropped(7);
  FrameCounts counts = tally.Take();
  EXPECT_EQ(counts.frames, 4u);
  EXPECT_EQ(counts.tracked, 3u);
  EXPECT_EQ(counts.dropped, 7u);
  EXPECT_EQ(counts.median_points, 20);
  tally.SetDropped(9);
  counts = tally.Take();
  EXPECT_EQ(counts.frames, 0u);
  EXPECT_EQ(counts.dropped, 2u);
  EXPECT_FALSE(counts.median_points.has_value());
}

TEST(RobotMinutesTest, TheLineSaysHowTheRobotFares) {
  RobotMinute minute;
  minute.took = absl::Seconds(60);
  minute.frames = {1800, 1790, 3, 312};
  minute.status.state = TrackingState::kTracking;
  minute.status.keyframes = 145;
  minute.status.local_maps = 2;
  minute.status.upload.batches = 4;
  minute.status.upload.memory_bytes = 3 << 19;
  minute.link = absl::UnavailableError("store.lan: no such name");
  minute.rss_bytes = 200 << 20;
  EXPECT_EQ(FormatMinute(minute),
            "tracking; not connected: store.lan: no such name; 30.0 frames/s: 1790 of 1800 "
            "tracked, 3 dropped, 312 points in the median frame; 145 keyframes in 2 local maps; 4 "
            "batches wait (1.5 MiB in memory, 0.0 MiB on disk); memory 200.0 MiB");
  minute.link = absl::OkStatus();
  EXPECT_THAT(FormatMinute(minute), AllOf(HasSubstr("; connected, 4"), Not(HasSubstr("not con"))));
  minute.status.upload.frames = 60;
  EXPECT_THAT(FormatMinute(minute),
              HasSubstr("on disk), 60 frames of the trajectory wait; memory"));
  minute.status.upload.frames = 0;
  minute.link = std::nullopt;
  EXPECT_THAT(FormatMinute(minute), AllOf(HasSubstr("; no map store;"), Not(HasSubstr("batches"))));
}

TEST(RobotMinutesTest, AMinuteWithoutFramesIsSaidToo) {
  RobotMinute minute;
  minute.took = absl::Seconds(60);
  minute.status.state = TrackingState::kLost;
  EXPECT_THAT(FormatMinute(minute), StartsWith("lost; 0.0 frames/s: 0 of 0 tracked"));
}

TEST(RobotMinutesTest, AStandingAndAFinishedRobotAreNotTracking) {
  RobotMinute minute;
  minute.took = absl::Seconds(60);
  minute.status.state = TrackingState::kTracking;
  minute.report =
      AgentReport{.activity = AgentActivity::kWaiting, .frames = 9, .newest_frame_age_s = 12.2};
  EXPECT_THAT(FormatMinute(minute),
              StartsWith("waiting: no frame for 12 s, tracking until then; 0.0 frames/s"));
  minute.report->frames = 0;
  EXPECT_THAT(FormatMinute(minute), StartsWith("waiting: no frame has come yet; 0.0 frames/s"));
  minute.report->activity = AgentActivity::kFinished;
  EXPECT_THAT(FormatMinute(minute), StartsWith("finished: the source has ended; 0.0 frames/s"));
  minute.report->activity = AgentActivity::kTracking;
  minute.localise_only = true;
  EXPECT_THAT(FormatMinute(minute), StartsWith("tracking (it only localises); 0.0 frames/s"));
}

class IdleAgent : public Agent {
 public:
  absl::StatusOr<TrackingResult> Track(const SensorImages&) override { return TrackingResult(); }
  void BeginLocalMap() override {}
  void Step() override {}
  absl::Status Finish(absl::Duration) override { return absl::OkStatus(); }
  AgentStatus GetStatus() const override { return {}; }
  std::optional<Similarity3d> GlobalFromLocal() const override { return std::nullopt; }
  AgentTimings GetTimings() const override { return {}; }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return {}; }
  Map CopyMap() const override { return {}; }
  std::optional<client_agent::NearMap> GetNearMap(
      const client_agent::NearMapLimits&) const override {
    return std::nullopt;
  }
};

class FirstLine : public google::LogSink {
 public:
  FirstLine() { google::AddLogSink(this); }
  ~FirstLine() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const google::LogMessageTime&,
            const char* message, size_t length) override {
    absl::MutexLock lock(&mutex);
    if (text.empty()) text.assign(message, length);
  }
  absl::Mutex mutex;
  std::string text ABSL_GUARDED_BY(mutex);
};

TEST(RobotMinutesTest, LinesComeWhileNoFrameComes) {
  FirstLine line;
  const IdleAgent agent;
  FrameTally tally;
  RobotMinutesOptions options;
  options.who = {.mission = "lab", .agent = "alpha"};
  options.every = absl::Milliseconds(10);
  const RobotMinutes minutes(&agent, &tally, options);
  absl::MutexLock lock(&line.mutex);
  const auto come = [&]() ABSL_SHARED_LOCKS_REQUIRED(line.mutex) { return !line.text.empty(); };
  ASSERT_TRUE(line.mutex.AwaitWithTimeout(absl::Condition(&come), absl::Seconds(20)));
  EXPECT_THAT(line.text,
              StartsWith("mission=lab agent=alpha waiting for a first frame with depth; 0.0"));
}

}  // namespace
}  // namespace corbslam::services
