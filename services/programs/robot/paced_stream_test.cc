#include "services/programs/robot/paced_stream.h"

#include <gtest/gtest.h>

#include <chrono>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "services/programs/robot/testing/queued_stream.h"

namespace corbslam::services {

using client_agent::StreamEnd;

namespace {

// Returns the numbers of the frames until the end.
std::vector<size_t> PlayAll(PacedStream& paced) {
  std::vector<size_t> numbers;
  while (true) {
    const auto frame = paced.Next();
    EXPECT_TRUE(frame.ok()) << frame.status();
    if (!frame.ok() || !frame->has_value()) return numbers;
    numbers.push_back((*frame)->frame.number);
  }
}

TEST(PacedStreamTest, AtFullPaceNothingIsDropped) {
  QueuedStream stream;
  for (size_t i = 0; i < 4; ++i) stream.PutFrame(i, 0);
  stream.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kMax, stop);
  EXPECT_EQ(PlayAll(paced), (std::vector<size_t>{0, 1, 2, 3}));
  EXPECT_EQ(paced.dropped(), 0u);
}

TEST(PacedStreamTest, AFrameIsDroppedWhereItsSuccessorIsDueAlready) {
  QueuedStream stream;
  // All frames have one time: each but the last is overtaken, however fast this machine is.
  for (size_t i = 0; i < 4; ++i) stream.PutFrame(i, 7);
  stream.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kSensor, stop);
  EXPECT_EQ(PlayAll(paced), (std::vector<size_t>{3}));
  EXPECT_EQ(paced.dropped(), 3u);
}

TEST(PacedStreamTest, WhatWasMeasuredBeforeADroppedFrameComesWithTheNext) {
  QueuedStream stream;
  stream.PutImuFrame(0, 7, {1, 2});
  stream.PutImuFrame(1, 7, {3});
  stream.PutImuFrame(2, 7, {4, 5});
  stream.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kSensor, stop);
  const auto frame = paced.Next();
  ASSERT_TRUE(frame.ok() && frame->has_value()) << frame.status();
  ASSERT_EQ((*frame)->frame.number, 2u);
  std::vector<int64_t> measured;
  for (const ImuSample& sample : (*frame)->images.imu) measured.push_back(sample.timestamp_ns);
  EXPECT_EQ(measured, (std::vector<int64_t>{1, 2, 3, 4, 5}));
}

TEST(PacedStreamTest, FramesWaitForTheirTimeAlsoPlayedBackwards) {
  QueuedStream stream;
  stream.PutFrame(0, 5);
  stream.PutFrame(1, 4.9);
  stream.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kSensor, stop);
  const absl::Time start = absl::Now();
  EXPECT_EQ(PlayAll(paced), (std::vector<size_t>{0, 1}));
  EXPECT_GE(absl::Now() - start, absl::Milliseconds(99));
}

TEST(PacedStreamTest, EachDriveIsPlayedInItsOwnTime) {
  QueuedStream stream;
  stream.PutFrame(0, 5000);
  stream.PutFrame(1, 10, 1);
  stream.PutFrame(2, 9000, 2);
  stream.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kSensor, stop);
  const absl::Time start = absl::Now();
  EXPECT_EQ(PlayAll(paced), (std::vector<size_t>{0, 1, 2}));
  EXPECT_LT(absl::Now() - start, absl::Seconds(60));
}

// A clock may jump ahead by less than what is noticed at once.
TEST(PacedStreamTest, ACamerasFrameIsDueWhenItComes) {
  QueuedStream stream;
  for (const double time_s : {5.0, 55.0}) {
    client_agent::StreamFrame frame;
    frame.frame.timestamp_ns = static_cast<int64_t>(time_s * 1e9);
    frame.came = std::chrono::steady_clock::now();
    stream.Put(client_agent::NextFrame(std::move(frame)));
  }
  stream.Put(StreamEnd());
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kSensor, stop);
  const absl::Time start = absl::Now();
  EXPECT_EQ(PlayAll(paced).size(), 2u);
  EXPECT_LT(absl::Now() - start, absl::Seconds(40));
}

TEST(PacedStreamTest, ALiveFrameDoesNotWaitForTheNextOne) {
  QueuedStream stream;
  stream.PutFrame(0, 1);
  const absl::Notification stop;
  PacedStream paced(stream, Pace::kSensor, stop);
  const auto frame = paced.Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  ASSERT_EQ(stream.asked().size(), 2u) << "for the frame, and whether another one is there";
  EXPECT_LE(stream.asked()[1], absl::Now());
}

TEST(PacedStreamTest, ASilentStreamCanBeStopped) {
  QueuedStream stream;
  absl::Notification stop;
  size_t silences = 0;
  stream.when_empty = [&] {
    if (++silences == 3) stop.Notify();
  };
  PacedStream paced(stream, Pace::kMax, stop);
  const auto frame = paced.Next();
  EXPECT_TRUE(frame.ok() && !frame->has_value());
  EXPECT_EQ(silences, 3u);
}

TEST(PacedStreamTest, AnErrorComesAfterTheFramesBeforeIt) {
  for (const Pace pace : {Pace::kMax, Pace::kSensor}) {
    QueuedStream stream;
    stream.PutFrame(0, 1);
    stream.Put(absl::DataLossError("frame 1: the cable is out"));
    stream.Put(StreamEnd());
    const absl::Notification stop;
    PacedStream paced(stream, pace, stop);
    const auto frame = paced.Next();
    ASSERT_TRUE(frame.ok() && frame->has_value()) << frame.status();
    EXPECT_EQ(paced.Next().status(), absl::DataLossError("frame 1: the cable is out"));
  }
}

}  // namespace
}  // namespace corbslam::services
