#include "client_agent/source/bag/bag_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int64_t kMs = 1'000'000;

struct Sent {
  int64_t stamp_ms = 0;
  int64_t recorded_ms = 0;
  uint32_t publisher = 0;
};

// A topic with these messages, whose places are their numbers.
BagTopic TopicOf(const std::string& name, const std::vector<Sent>& sent) {
  BagTopic topic;
  topic.name = name;
  for (const Sent& one : sent) {
    while (topic.publishers.size() <= one.publisher) {
      BagPublisher added;
      added.frame_id = "frame_" + std::to_string(topic.publishers.size());
      topic.publishers.push_back(added);
    }
    BagPublisher& publisher = topic.publishers[one.publisher];
    if (publisher.messages++ == 0) publisher.first_ns = one.recorded_ms * kMs;
    publisher.last_ns = one.recorded_ms * kMs;
    PictureMessage message;
    message.stamp_ns = one.stamp_ms * kMs;
    message.recorded_ns = one.recorded_ms * kMs;
    message.place.place.offset = topic.pictures.size();
    message.publisher = one.publisher;
    topic.pictures.push_back(message);
  }
  topic.messages = topic.pictures.size();
  return topic;
}

// Messages that were recorded 3 ms after their stamps.
BagTopic Stamped(const std::string& name, const std::vector<int64_t>& stamps_ms) {
  std::vector<Sent> sent;
  for (const int64_t stamp_ms : stamps_ms) sent.push_back({stamp_ms, stamp_ms + 3, 0});
  return TopicOf(name, sent);
}

FramePairing Pairing(int64_t within_ms) {
  FramePairing pairing;
  pairing.bag = "test.bag";
  pairing.within_ns = within_ms * kMs;
  return pairing;
}

std::vector<int64_t> TimesOf(const BagFrames& made) {
  std::vector<int64_t> times_ms;
  for (const BagFrame& frame : made.frames) times_ms.push_back(frame.timestamp_ns / kMs);
  return times_ms;
}

std::vector<std::string> CodesOf(const SourceRemarks& remarks) {
  std::vector<std::string> codes;
  for (const SourceFinding& finding : remarks.findings) codes.push_back(finding.code);
  return codes;
}

TEST(BagFramesTest, NearestInTimeArePairs) {
  SourceRemarks remarks;
  const auto made = MakeBagFrames(Stamped("left", {100, 200, 300}),
                                  Stamped("right", {101, 199, 301}), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 200, 300));
  EXPECT_EQ(made->frames[1].second.place.offset, 1u);
  EXPECT_THAT(remarks.findings, IsEmpty());
}

TEST(BagFramesTest, WhatHasNoCounterpartIsTold) {
  SourceRemarks remarks;
  const auto made = MakeBagFrames(Stamped("left", {100, 200, 300, 400}),
                                  Stamped("right", {100, 300, 401}), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 300, 400));
  EXPECT_THAT(CodesOf(remarks), ElementsAre("pairs-incomplete"));
}

TEST(BagFramesTest, MessagesOutOfOrderArePutInOrder) {
  SourceRemarks remarks;
  const BagTopic left = TopicOf("left", {{100, 103}, {300, 310}, {200, 320}, {400, 430}});
  const auto made =
      MakeBagFrames(left, Stamped("right", {100, 200, 300, 400}), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 200, 300, 400));
  EXPECT_EQ(made->frames[1].first.place.offset, 2u);
  EXPECT_THAT(CodesOf(remarks), ElementsAre("times-out-of-order"));
}

TEST(BagFramesTest, AFileInAnotherOrderThanItWasRecordedInIsNothingToTell) {
  SourceRemarks remarks;
  const BagTopic left = TopicOf("left", {{3000, 3003}, {5000, 5003}, {1000, 1003}});
  const auto made = MakeBagFrames(left, Stamped("right", {1000, 3000, 5000}), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(1000, 3000, 5000));
  EXPECT_THAT(remarks.findings, IsEmpty());
}

TEST(BagFramesTest, RepeatedTimesAreTakenOnce) {
  SourceRemarks remarks;
  const auto made = MakeBagFrames(Stamped("left", {100, 200, 200, 300}),
                                  Stamped("right", {100, 200, 300}), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 200, 300));
  EXPECT_THAT(CodesOf(remarks), ElementsAre("times-repeat"));
}

TEST(BagFramesTest, ABagThatWasPlayedTwiceIsTwoDrives) {
  SourceRemarks remarks;
  const std::vector<Sent> twice = {{1000, 1},    {2000, 1001}, {3000, 2001},
                                   {1000, 3001}, {2000, 4001}, {3000, 5001}};
  const auto made =
      MakeBagFrames(TopicOf("left", twice), TopicOf("right", twice), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(1000, 2000, 3000, 1000, 2000, 3000));
  EXPECT_EQ(made->frames[2].drive, 0);
  EXPECT_EQ(made->frames[3].drive, 1);
  EXPECT_EQ(made->frames[3].second.place.offset, 3u);
  EXPECT_THAT(CodesOf(remarks), ElementsAre("times-jump-back"));
}

TEST(BagFramesTest, OfTwoPublishersAtOnceOneIsPlayed) {
  SourceRemarks remarks;
  std::vector<Sent> both;
  for (int64_t i = 0; i < 6; ++i) both.push_back({100 * i, 100 * i, 0});
  both.push_back({150, 150, 1});
  both.push_back({350, 350, 1});
  const auto made =
      MakeBagFrames(TopicOf("left", both), Stamped("right", {0, 100, 150, 200, 300, 350, 400, 500}),
                    Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(0, 100, 200, 300, 400, 500));
  EXPECT_THAT(CodesOf(remarks), ElementsAre("bag-two-publishers", "pairs-incomplete"));
  EXPECT_THAT(remarks.findings[0].text, HasSubstr("frame 'frame_1', 2 messages"));
}

TEST(BagFramesTest, ADriverThatWasRestartedIsOneTopic) {
  SourceRemarks remarks;
  const BagTopic left = TopicOf("left", {{0, 0, 0}, {100, 100, 0}, {200, 200, 1}, {300, 300, 1}});
  const auto made = MakeBagFrames(left, Stamped("right", {0, 100, 200, 300}), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(0, 100, 200, 300));
  EXPECT_THAT(remarks.findings, IsEmpty());
}

TEST(BagFramesTest, WithoutStampsTheRecordersTimesAreTaken) {
  SourceRemarks remarks;
  const std::vector<Sent> unstamped = {{0, 100}, {0, 200}, {0, 300}};
  const auto made =
      MakeBagFrames(TopicOf("left", unstamped), TopicOf("right", {{0, 101}, {0, 201}, {0, 301}}),
                    Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_TRUE(made->by_recording_time);
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 200, 300));
  EXPECT_THAT(CodesOf(remarks), ElementsAre("bag-unstamped"));
}

TEST(BagFramesTest, TheRecordersTimesAreTakenWhereAsked) {
  SourceRemarks remarks;
  FramePairing pairing = Pairing(2);
  pairing.by_recording_time = true;
  const auto made = MakeBagFrames(TopicOf("left", {{5, 100}, {6, 200}}),
                                  TopicOf("right", {{900, 100}, {901, 200}}), pairing, remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 200));
}

TEST(BagFramesTest, ClocksThatDifferAreNamed) {
  SourceRemarks remarks;
  const auto made = MakeBagFrames(Stamped("left", {100, 200}), Stamped("right", {50'100, 50'200}),
                                  Pairing(2), remarks);
  EXPECT_THAT(made.status().message(), HasSubstr("left has 2 from 0.100000000 to 0.200000000 s"));
  EXPECT_THAT(made.status().message(), HasSubstr("?time=recording"));
}

TEST(BagFramesTest, StampsThatAreGarbageAreToldShortly) {
  SourceRemarks remarks;
  std::vector<Sent> garbage;
  for (int64_t i = 0; i < 1000; ++i) garbage.push_back({i % 2 == 0 ? 900'000 : 5'000, 100 * i});
  (void)MakeBagFrames(TopicOf("left", garbage), Stamped("right", {1, 2}), Pairing(2), remarks);
  EXPECT_LT(remarks.findings.size(), 10u);
  std::vector<Sent> early = {{-5'000, 100}, {5, 200}};
  const auto made =
      MakeBagFrames(TopicOf("left", early), TopicOf("right", early), Pairing(2), remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(5));
}

TEST(BagFramesTest, AKnownDelayIsTakenOff) {
  SourceRemarks remarks;
  FramePairing pairing = Pairing(2);
  pairing.second_offset_ns = 50 * kMs;
  const auto made =
      MakeBagFrames(Stamped("left", {100, 200}), Stamped("depth", {50, 150}), pairing, remarks);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(TimesOf(*made), ElementsAre(100, 200));
}

}  // namespace
}  // namespace corbslam::client_agent
