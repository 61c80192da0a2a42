#include "client_agent/agent/agent_events.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace corbslam::client_agent {
namespace {

using Kind = AgentEvent::Kind;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kMap = {1};

class AgentEventsTest : public ::testing::Test {
 protected:
  void Frame(TrackingState state, uint64_t epoch, uint64_t global_epoch = 0,
             LocalMapId local_map = kMap) {
    TrackingResult result;
    result.timestamp_ns = ++time_ns_;
    result.state = state;
    result.local_map = local_map;
    result.epoch = epoch;
    events_.NoteFrame(result, global_epoch);
  }
  std::vector<AgentEvent> All(uint64_t after = 0) const {
    std::vector<AgentEvent> all;
    while (const auto event = events_.After(after)) {
      all.push_back(*event);
      after = event->number;
    }
    return all;
  }
  std::vector<Kind> Kinds(uint64_t after = 0) const {
    std::vector<Kind> kinds;
    for (const AgentEvent& event : All(after)) kinds.push_back(event.kind);
    return kinds;
  }

  int64_t time_ns_ = 0;
  AgentEvents events_{[] { return absl::FromUnixSeconds(7); }};
};

TEST_F(AgentEventsTest, SaysWhatBecomesOfThePose) {
  Frame(TrackingState::kNotInitialised, 0);
  EXPECT_THAT(Kinds(), IsEmpty());
  Frame(TrackingState::kTracking, 1);
  Frame(TrackingState::kTracking, 1);
  Frame(TrackingState::kTracking, 2);
  Frame(TrackingState::kLost, 2);
  Frame(TrackingState::kLost, 2);
  Frame(TrackingState::kTracking, 3);
  EXPECT_THAT(Kinds(), ElementsAre(Kind::kLocalMapBegun, Kind::kMapCorrected, Kind::kLost,
                                   Kind::kRelocalised));
  const AgentEvent last = All().back();
  EXPECT_EQ(last.number, 4u);
  EXPECT_EQ(last.timestamp_ns, 7);
  EXPECT_EQ(last.local_map, kMap);
  EXPECT_EQ(last.epoch, 3u);
  EXPECT_EQ(last.time, absl::FromUnixSeconds(7));
}

TEST_F(AgentEventsTest, AnotherLocalMapIsNoRelocalisation) {
  Frame(TrackingState::kTracking, 1);
  Frame(TrackingState::kLost, 1);
  Frame(TrackingState::kNotInitialised, 1, 0, {2});
  Frame(TrackingState::kTracking, 2, 0, {2});
  EXPECT_THAT(Kinds(), ElementsAre(Kind::kLocalMapBegun, Kind::kLost, Kind::kLocalMapBegun));
  EXPECT_EQ(All().back().local_map, (LocalMapId{2}));
}

TEST_F(AgentEventsTest, TheGlobalFrameMovesWhilePosesGoOn) {
  Frame(TrackingState::kTracking, 1);
  events_.NoteLink(LinkEvent::kMerged, kMap);
  Frame(TrackingState::kTracking, 1, 1);
  Frame(TrackingState::kTracking, 1, 1);
  events_.NoteLink(LinkEvent::kSplit, kMap);
  Frame(TrackingState::kTracking, 1, 2);
  events_.NoteLink(LinkEvent::kMissionDeleted, kMap);
  EXPECT_THAT(Kinds(), ElementsAre(Kind::kLocalMapBegun, Kind::kMerged, Kind::kGlobalFrameMoved,
                                   Kind::kSplit, Kind::kGlobalFrameMoved, Kind::kMissionDeleted));
  EXPECT_EQ(All()[1].global_epoch, 0u);
  EXPECT_EQ(All()[2].global_epoch, 1u);
}

TEST_F(AgentEventsTest, KeepsTheNewestThousandAndASlowReaderSkips) {
  Frame(TrackingState::kTracking, 1);
  for (size_t i = 1; i < AgentEvents::kMaxEvents + 20; ++i) {
    events_.NoteLink(LinkEvent::kMerged, kMap);
  }
  const std::vector<AgentEvent> all = All();
  ASSERT_EQ(all.size(), AgentEvents::kMaxEvents);
  EXPECT_EQ(all.front().number, 21u);
  EXPECT_EQ(all.back().number, AgentEvents::kMaxEvents + 20);
  EXPECT_EQ(events_.After(5)->number, 21u);
  EXPECT_EQ(events_.After(500)->number, 501u);
  EXPECT_FALSE(events_.After(all.back().number).has_value());
  EXPECT_EQ(events_.After(1'000'000)->number, 21u) << "a number of the process before";
}

// A robot that only localises is told of the global frame before its first frame comes.
TEST_F(AgentEventsTest, ALocalMapBeginsBeforeItIsMerged) {
  events_.NoteLink(LinkEvent::kMerged, kMap);
  Frame(TrackingState::kNotInitialised, 0);
  EXPECT_THAT(Kinds(), IsEmpty());
  Frame(TrackingState::kTracking, 1, 1);
  EXPECT_THAT(Kinds(), ElementsAre(Kind::kLocalMapBegun, Kind::kGlobalFrameMoved, Kind::kMerged));
  EXPECT_EQ(All().back().local_map, kMap);
  // What was taken back before it began was never so for anybody.
  events_.NoteLink(LinkEvent::kMerged, {2});
  events_.NoteLink(LinkEvent::kSplit, {2});
  Frame(TrackingState::kTracking, 2, 1, {2});
  EXPECT_THAT(Kinds(3), ElementsAre(Kind::kLocalMapBegun));
}

TEST_F(AgentEventsTest, TheEndIsSaidOnce) {
  Frame(TrackingState::kTracking, 1);
  EXPECT_FALSE(events_.ended().has_value());
  events_.NoteEnd();
  events_.NoteEnd();
  EXPECT_EQ(events_.ended(), 2u);
  EXPECT_THAT(Kinds(), ElementsAre(Kind::kLocalMapBegun, Kind::kEnded));
}

TEST_F(AgentEventsTest, ListenersHearAndMayAsk) {
  std::vector<uint64_t> heard;
  const uint64_t token = events_.AddListener(
      [&] { heard.push_back(events_.After(heard.empty() ? 0 : heard.back())->number); });
  Frame(TrackingState::kTracking, 1);
  Frame(TrackingState::kTracking, 1);
  Frame(TrackingState::kLost, 1);
  events_.RemoveListener(token);
  Frame(TrackingState::kTracking, 2);
  EXPECT_THAT(heard, ElementsAre(1, 2));
}

}  // namespace
}  // namespace corbslam::client_agent
