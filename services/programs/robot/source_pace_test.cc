#include "services/programs/robot/source_pace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/programs/robot/paced_stream.h"
#include "services/programs/robot/testing/queued_stream.h"

namespace corbslam::services {

using client_agent::StreamEnd;

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A source of which each frame takes `made_in` and whose times are `apart`.
SourcePace Played(int frames, absl::Duration made_in, absl::Duration apart) {
  SourcePace pace;
  for (int i = 0; i < frames; ++i) {
    pace.OnFrame(absl::UnixEpoch() + i * made_in, std::max(made_in - apart, absl::ZeroDuration()));
  }
  return pace;
}

TEST(SourcePaceTest, ASourceThatTakesTwiceItsIntervalIsTooSlow) {
  const SourcePace pace = Played(100, absl::Milliseconds(100), absl::Milliseconds(50));
  EXPECT_TRUE(pace.IsTooSlow());
  EXPECT_EQ(pace.frame_time(), absl::Milliseconds(100));
  EXPECT_EQ(pace.held(), absl::Seconds(5));
  EXPECT_THAT(DescribeSlowSource(pace, 0.05),
              AllOf(HasSubstr("the source itself is too slow"), HasSubstr("each 100 ms"),
                    HasSubstr("each 50 ms"), HasSubstr("5.0 s"), Not(HasSubstr("too fast"))));
}

TEST(SourcePaceTest, OneThatKeepsUpOrStumblesOnceIsNot) {
  EXPECT_FALSE(Played(1000, absl::Milliseconds(50), absl::Milliseconds(50)).IsTooSlow());
  SourcePace pace = Played(1000, absl::Milliseconds(50), absl::Milliseconds(50));
  pace.OnFrame(absl::UnixEpoch() + absl::Seconds(52), absl::Seconds(2));
  EXPECT_FALSE(pace.IsTooSlow());
}

TEST(SourcePaceTest, NoFrameIsDroppedBecauseTheSourceItselfIsSlow) {
  QueuedStream slow;
  slow.live = false;
  slow.makes_in = absl::Milliseconds(20);
  for (size_t i = 0; i < 20; ++i) slow.PutFrame(i, 0.001 * static_cast<double>(i));
  slow.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(slow, Pace::kSensor, stop);
  size_t played = 0;
  while (true) {
    const auto frame = paced.Next();
    ASSERT_TRUE(frame.ok()) << frame.status();
    if (!frame->has_value()) break;
    ++played;
  }
  EXPECT_EQ(played, 20u);
  EXPECT_EQ(paced.dropped(), 0u);
  EXPECT_GE(paced.source_pace().held(), absl::Milliseconds(19 * 15));
}

TEST(SourcePaceTest, ARobotThatIsSlowStillDropsFramesOfARecording) {
  QueuedStream recording;
  recording.live = false;
  for (size_t i = 0; i < 20; ++i) recording.PutFrame(i, 0.001 * static_cast<double>(i));
  recording.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(recording, Pace::kSensor, stop);
  size_t played = 0;
  while (true) {
    const auto frame = paced.Next();
    ASSERT_TRUE(frame.ok()) << frame.status();
    if (!frame->has_value()) break;
    ++played;
    absl::SleepFor(absl::Milliseconds(30));
  }
  EXPECT_LT(played, 10u);
  EXPECT_EQ(played + paced.dropped(), 20u);
}

}  // namespace
}  // namespace corbslam::services
