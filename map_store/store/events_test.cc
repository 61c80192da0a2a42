// Tests which events a mission's life makes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "map_store/testing/byte_journal.h"
#include "map_store/testing/small_mission.h"
#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using testing::TestAgent;

class EventsTest : public testing::TwoRobots {
 protected:
  // Returns the events since the last call.
  std::vector<MissionEvent> Take() {
    std::vector<MissionEvent> events;
    while (const auto event = *store_.EventAfter(kMission, known_)) {
      EXPECT_EQ(event->number, known_ + 1);
      EXPECT_EQ(event->missed, 0u);
      EXPECT_GE(event->revision, revision_);
      known_ = event->number;
      revision_ = event->revision;
      events.push_back(*event);
    }
    return events;
  }
  // Returns those of one kind among them.
  template <typename Kind>
  static std::vector<Kind> Of(const std::vector<MissionEvent>& events) {
    std::vector<Kind> found;
    for (const MissionEvent& event : events) {
      if (const auto* what = std::get_if<Kind>(&event.what)) found.push_back(*what);
    }
    return found;
  }
  // Returns both robots' maps as one island.
  void Merge() {
    StreamBoth();
    Fuse();
    Take();
  }

  uint64_t known_ = 0;
  uint64_t revision_ = 0;
};

TEST_F(EventsTest, RobotsComeBeginMapsGetLostAndGo) {
  auto events = Take();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(std::get<MissionEvent::AgentJoined>(events[0].what).agent, "a");
  EXPECT_EQ(std::get<MissionEvent::AgentJoined>(events[1].what).agent, "b");
  ASSERT_TRUE(a_.Stream(2).ok());
  MapUpdateBatch lost = a_.EmptyBatch();
  lost.lost_frames_ns = {500'000'000'000, 500'100'000'000};
  ASSERT_TRUE(a_.Send(lost).ok());
  ASSERT_TRUE(a_.Send(lost).ok()) << "a batch that comes again";
  events = Take();
  ASSERT_EQ(events.size(), 2u);
  const auto begun = std::get<MissionEvent::LocalMapBegun>(events[0].what);
  EXPECT_EQ(begun.local_map, a_.local_map());
  EXPECT_EQ(begun.agent, "a");
  const auto tracking = std::get<MissionEvent::TrackingLost>(events[1].what);
  EXPECT_EQ(tracking.local_map, a_.local_map());
  EXPECT_EQ(tracking.agent, "a");
  EXPECT_EQ(tracking.frames, 2u);
  for (const size_t frames : {3u, 0u, 1u}) {
    MapUpdateBatch next = a_.EmptyBatch();
    for (size_t i = 0; i < frames; ++i) {
      next.lost_frames_ns.push_back(501'000'000'000 + static_cast<int64_t>(10 * next.number + i));
    }
    ASSERT_TRUE(a_.Send(next).ok());
  }
  const auto again = Of<MissionEvent::TrackingLost>(Take());
  ASSERT_EQ(again.size(), 1u) << "while it stays lost, that is no news";
  EXPECT_EQ(again.front().frames, 1u);
  store_.CloseSession(b_.session());
  store_.CloseSession(b_.session());
  events = Take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<MissionEvent::AgentLeft>(events[0].what).agent, "b");
  EXPECT_FALSE(std::get<MissionEvent::AgentLeft>(events[0].what).on_purpose);
  store_.CloseSession(a_.session(), /*on_purpose=*/true);
  const auto left = Of<MissionEvent::AgentLeft>(Take());
  ASSERT_EQ(left.size(), 1u);
  EXPECT_TRUE(left[0].on_purpose);
}

TEST_F(EventsTest, AMapThatARobotGoesWithoutIsNamedOnce) {
  ASSERT_TRUE(a_.Stream(2).ok());
  Take();
  AgentReport report;
  const auto say = [&] { return store_.NoteReport(b_.session(), report); };
  ASSERT_TRUE(say().ok());
  // One that nobody knows is no news.
  report.contradictions = {{LocalMapId{0xff}, 0.9, 0.001}, {a_.local_map(), 1.02, 0.001}};
  ASSERT_TRUE(say().ok());
  ASSERT_TRUE(say().ok()) << "each report says it again";
  const auto found = Of<MissionEvent::MapContradicted>(Take());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].agent, "b");
  EXPECT_EQ(found[0].owner, "a");
  EXPECT_EQ(found[0].found, report.contradictions[1]);
  // Nobody goes without the map that it makes itself.
  ASSERT_TRUE(store_.NoteReport(a_.session(), report).ok());
  EXPECT_TRUE(Of<MissionEvent::MapContradicted>(Take()).empty());
}

TEST_F(EventsTest, WhoseNewerSessionTakesItsPlaceHasNotLeft) {
  Take();
  const TestAgent again(store_, kMission, "a", map_a_);
  store_.CloseSession(a_.session());
  const auto events = Take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<MissionEvent::AgentJoined>(events[0].what));
  store_.CloseSession(again.session());
  EXPECT_EQ(Of<MissionEvent::AgentLeft>(Take()).size(), 1u);
}

TEST_F(EventsTest, MapsMeetBecomeOneAndAreAdjusted) {
  StreamBoth();
  Take();
  Fuse();
  const auto events = Take();
  const auto overlaps = Of<MissionEvent::OverlapAccepted>(events);
  EXPECT_EQ(overlaps.size(), Statistics().overlaps_accepted);
  const auto accepted = store_.ListOverlaps(kMission, {true, {}}, {});
  ASSERT_EQ(accepted->items.size(), overlaps.size());
  for (size_t i = 0; i < overlaps.size(); ++i) {
    EXPECT_EQ(overlaps[i].overlap, accepted->items[i].id);
    EXPECT_EQ(overlaps[i].query, accepted->items[i].overlap.query.local_map);
    EXPECT_EQ(overlaps[i].candidate, accepted->items[i].overlap.candidate.local_map);
  }
  const auto merged = Of<MissionEvent::IslandsMerged>(events);
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_THAT(merged[0].local_maps, ElementsAre(a_.local_map(), b_.local_map()));
  EXPECT_THAT(merged[0].agents, ElementsAre("a", "b"));
  EXPECT_EQ(merged[0].ms, Statistics().merge_ms.at(0));
  const auto adjusted = Of<MissionEvent::MapAdjusted>(events);
  ASSERT_EQ(adjusted.size(), 1u);
  EXPECT_EQ(adjusted[0].island, a_.local_map());
  const GlobalAdjustmentStatistics adjustment = Statistics().global_adjustments.at(0);
  EXPECT_EQ(adjusted[0].keyframes, static_cast<size_t>(adjustment.keyframes));
  EXPECT_EQ(adjusted[0].map_points, static_cast<size_t>(adjustment.map_points));
  EXPECT_GE(adjusted[0].ms, 0);
  EXPECT_LT(adjusted[0].ms, 600'000);
  EXPECT_EQ(events.back().revision, Statistics().revision);
}

TEST_F(EventsTest, ALoopIsClosedInTheIsland) {
  Merge();
  MapUpdateBatch loop = b_.EmptyBatch();
  loop.loop_edges.push_back({b_.Id(10), b_.Id(0), Similarity3d()});
  ASSERT_TRUE(b_.Send(loop).ok());
  Fuse();
  const auto events = Take();
  const auto closed = Of<MissionEvent::LoopClosed>(events);
  ASSERT_EQ(closed.size(), 1u);
  EXPECT_THAT(closed[0].local_maps, ::testing::Contains(b_.local_map()));
  EXPECT_TRUE(Of<MissionEvent::IslandsMerged>(events).empty());
  EXPECT_FALSE(Of<MissionEvent::MapAdjusted>(events).empty());
}

TEST_F(EventsTest, PeopleTakeBackAndForget) {
  Merge();
  const uint64_t overlap = store_.ListOverlaps(kMission, {true, {}}, {})->items.front().id;
  const auto taken_back = store_.RetractOverlap(kMission, overlap, true);
  ASSERT_TRUE(taken_back.ok()) << taken_back.status();
  auto events = Take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<MissionEvent::OverlapsTakenBack>(events[0].what).overlaps, *taken_back);
  EXPECT_EQ(events[0].revision, Statistics().revision);
  ASSERT_TRUE(store_.RederiveGlobalLayer(kMission).ok());
  events = Take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<MissionEvent::GlobalLayerForgotten>(events[0].what));
  EXPECT_EQ(events[0].revision, Statistics().revision);
  ASSERT_FALSE(store_.RetractOverlap(kMission, 999, false).ok());
  EXPECT_TRUE(Take().empty());
}

TEST_F(EventsTest, ListenersHearOfEventsAndOfTheEnd) {
  int calls = 0;
  const auto token = store_.AddEventListener(kMission, [&calls] { ++calls; });
  ASSERT_TRUE(token.ok());
  ASSERT_TRUE(a_.Stream(1).ok());
  const int first = calls;
  EXPECT_GE(first, 1);
  ASSERT_TRUE(a_.Stream(1).ok());
  EXPECT_EQ(calls, first) << "nothing has happened";
  ASSERT_TRUE(store_.DeleteMission(kMission).ok());
  EXPECT_GT(calls, first);
  EXPECT_TRUE(absl::IsNotFound(store_.EventAfter(kMission, 0).status()));
  EXPECT_TRUE(absl::IsNotFound(store_.AddEventListener(kMission, [] {}).status()));
}

TEST(RecoveredEventsTest, AReplayMakesNone) {
  auto bytes = std::make_shared<testing::JournalBytes>();
  testing::ByteJournal journal(bytes);
  for (const JournalRecord& record : testing::MakeSmallMission()) {
    ASSERT_TRUE(journal.Append(bytes->mission, record).ok());
  }
  MapStoreOptions options;
  options.deterministic = true;
  MapStore store(options, nullptr, std::make_unique<testing::ByteJournal>(bytes), nullptr);
  ASSERT_TRUE(store.Recover().ok());
  const auto event = store.EventAfter(bytes->mission, 0);
  ASSERT_TRUE(event.ok()) << event.status();
  EXPECT_FALSE(event->has_value());
}

}  // namespace
}  // namespace corbslam::map_store
