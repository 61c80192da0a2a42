#include "services/viewer/mission_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "services/viewer/testing/map_changes.h"

namespace corbslam::services {
namespace {

using testing::ChangesWriter;
using testing::kFirst;
using Part = v1::ViewerMessage::PartCase;

std::optional<v1::ViewerMessage> Read(const MissionFeed& feed, FeedReader& reader) {
  const EncodedMessage encoded = feed.Next(reader);
  if (encoded == nullptr) return std::nullopt;
  v1::ViewerMessage message;
  EXPECT_TRUE(message.ParseFromString(*encoded));
  return message;
}

// Reads until there is nothing more; takes the map's part into `mirror`.
std::vector<Part> ReadAll(const MissionFeed& feed, FeedReader& reader, MapMirror& mirror) {
  std::vector<Part> parts;
  while (const auto message = Read(feed, reader)) {
    parts.push_back(message->part_case());
    if (message->has_reset()) mirror.Clear();
    if (message->has_map()) {
      EXPECT_TRUE(mirror.Apply(message->map()).ok());
    }
  }
  return parts;
}

v1::WatchMapResponse SomeKeyframes(uint64_t version, uint32_t begin, uint32_t end) {
  ChangesWriter writer(version);
  writer.Island(kFirst, {kFirst}, version == 1);
  for (uint32_t i = begin; i < end; ++i) {
    writer.Keyframe({kFirst, i}, i).Point({kFirst, i}, 1.0F);
  }
  return writer.Take();
}

TEST(MissionFeedTest, APictureComesFirstThenWhatChanges) {
  MissionFeed feed;
  ASSERT_TRUE(feed.Apply(SomeKeyframes(1, 0, 20)).ok());
  FeedReader reader;
  const auto first = Read(feed, reader);
  ASSERT_TRUE(first && first->has_reset());
  EXPECT_EQ(first->reset().reason(), v1::MapReset::REASON_BEGIN);
  EXPECT_EQ(first->reset().keyframes(), 20U);
  EXPECT_EQ(first->reset().map_points(), 20U);
  MapMirror mirror;
  ReadAll(feed, reader, mirror);
  EXPECT_EQ(mirror.keyframes(), 20U);
  EXPECT_EQ(mirror.points(), 20U);
  ASSERT_TRUE(feed.Apply(SomeKeyframes(2, 20, 25)).ok());
  const auto change = Read(feed, reader);
  ASSERT_TRUE(change && change->has_map());
  EXPECT_EQ(change->map().islands(0).keyframes_size(), 5);
  EXPECT_FALSE(Read(feed, reader));
}

TEST(MissionFeedTest, WhoWantsNoPointsIsSentNone) {
  MissionFeed feed;
  ASSERT_TRUE(feed.Apply(SomeKeyframes(1, 0, 5)).ok());
  FeedReader reader{.with_points = false};
  const auto reset = Read(feed, reader);
  ASSERT_TRUE(reset);
  EXPECT_EQ(reset->reset().map_points(), 0U);
  MapMirror mirror;
  ReadAll(feed, reader, mirror);
  ASSERT_TRUE(feed.Apply(SomeKeyframes(2, 5, 9)).ok());
  ReadAll(feed, reader, mirror);
  EXPECT_EQ(mirror.keyframes(), 9U);
  EXPECT_EQ(mirror.points(), 0U);
}

TEST(MissionFeedTest, ASlowReaderBeginsAnewAndEndsRight) {
  MissionFeed feed({.max_log_bytes = 5000});
  ASSERT_TRUE(feed.Apply(SomeKeyframes(1, 0, 5)).ok());
  FeedReader slow;
  MapMirror mirror;
  ReadAll(feed, slow, mirror);
  for (uint64_t version = 2; version < 100; ++version) {
    const auto begin = static_cast<uint32_t>(5 * version);
    ASSERT_TRUE(feed.Apply(SomeKeyframes(version, begin, begin + 5)).ok());
  }
  const auto skip = Read(feed, slow);
  ASSERT_TRUE(skip && skip->has_reset());
  EXPECT_EQ(skip->reset().reason(), v1::MapReset::REASON_SKIPPED);
  mirror.Clear();
  ReadAll(feed, slow, mirror);
  EXPECT_EQ(mirror.keyframes(), 5U + 98 * 5);
  EXPECT_EQ(slow.skips, 1U);
}

TEST(MissionFeedTest, WhenTheStoreCameBackTheOldMapStaysUntilTheNewOneComes) {
  MissionFeed feed;
  ASSERT_TRUE(feed.Apply(SomeKeyframes(1, 0, 20)).ok());
  FeedReader reader;
  MapMirror mirror;
  ReadAll(feed, reader, mirror);
  feed.BeginAnew();
  EXPECT_FALSE(Read(feed, reader));
  FeedReader newcomer;
  MapMirror seen;
  ReadAll(feed, newcomer, seen);
  EXPECT_EQ(seen.keyframes(), 20U);
  ASSERT_TRUE(feed.Apply(SomeKeyframes(1, 0, 3)).ok());
  const auto reset = Read(feed, reader);
  ASSERT_TRUE(reset && reset->has_reset());
  EXPECT_EQ(reset->reset().reason(), v1::MapReset::REASON_RECONNECTED);
  mirror.Clear();
  ReadAll(feed, reader, mirror);
  EXPECT_EQ(mirror.keyframes(), 3U);
}

TEST(MissionFeedTest, EventsAreRememberedAndOfPulsesTheNewest) {
  MissionFeed feed({.max_events = 3});
  for (uint64_t number = 1; number <= 5; ++number) {
    v1::MissionEvent event;
    event.set_number(number);
    feed.AddEvent(event);
  }
  v1::MissionPulse pulse;
  for (int64_t time = 1; time <= 3; ++time) {
    pulse.set_time_ns(time);
    feed.SetPulse(pulse);
  }
  EXPECT_EQ(feed.newest_event(), 5U);
  FeedReader reader;
  ASSERT_TRUE(Read(feed, reader)->has_reset());
  const auto newest = Read(feed, reader);
  ASSERT_TRUE(newest && newest->has_pulse());
  EXPECT_EQ(newest->pulse().time_ns(), 3);
  EXPECT_GT(newest->pulse().sent_bytes(), 0U);
  std::vector<uint64_t> numbers;
  while (const auto message = Read(feed, reader)) {
    if (message->has_event()) numbers.push_back(message->event().number());
  }
  EXPECT_THAT(numbers, ::testing::ElementsAre(3, 4, 5));
}

TEST(MissionFeedTest, ListenersHearOfEverything) {
  MissionFeed feed;
  int calls = 0;
  const uint64_t token = feed.AddListener([&calls] { ++calls; });
  ASSERT_TRUE(feed.Apply(SomeKeyframes(1, 0, 2)).ok());
  feed.AddEvent({});
  feed.SetPulse({});
  EXPECT_EQ(calls, 3);
  feed.RemoveListener(token);
  feed.SetPulse({});
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(feed.listeners(), 0U);
}

TEST(MissionFeedTest, ABadChangeIsSaid) {
  MissionFeed feed;
  v1::WatchMapResponse changes = SomeKeyframes(1, 0, 2);
  changes.mutable_islands(0)->set_slot(100);
  EXPECT_EQ(feed.Apply(changes).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam::services
