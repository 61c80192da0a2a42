// Tests what is kept of a long trajectory, and what goes.
#include "map_store/state/localised_track.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr size_t kMany = 1000;

LocalisedFrames Part(uint64_t run, uint64_t number, const std::vector<int64_t>& tracked_ns,
                     const std::vector<int64_t>& lost_ns = {}) {
  LocalisedFrames part;
  part.run = run;
  part.number = number;
  for (const int64_t time_ns : tracked_ns) part.tracked_frames.push_back({time_ns, {{1}, 0}, {}});
  part.lost_frames_ns = lost_ns;
  return part;
}

std::vector<int64_t> TimesOf(const LocalisedRun& run) {
  std::vector<int64_t> times;
  for (const TrackedFrame& frame : run.frames) times.push_back(frame.timestamp_ns);
  return times;
}

TEST(LocalisedTrackTest, PartsFollowEachOtherAndRunsDoNotMix) {
  LocalisedTrack track;
  AddPart(Part(7, 1, {10, 20}), kMany, track);
  AddPart(Part(8, 1, {5}), kMany, track);
  AddPart(Part(7, 2, {30}), kMany, track);
  ASSERT_EQ(track.runs.size(), 2u);
  EXPECT_THAT(TimesOf(*FindRun(track, 7)), ElementsAre(10, 20, 30));
  EXPECT_EQ(FindRun(track, 7)->last_number, 2u);
  EXPECT_THAT(TimesOf(*FindRun(track, 8)), ElementsAre(5));
  EXPECT_EQ(FindRun(track, 9), nullptr);
}

TEST(LocalisedTrackTest, OfALongLossTheEndsAreKept) {
  LocalisedTrack track;
  AddPart(Part(7, 1, {50, 100}, {10, 20, 30, 60, 70, 80}), kMany, track);
  EXPECT_THAT(FindRun(track, 7)->lost_frames_ns, ElementsAre(10, 30, 60, 80));
  for (int64_t i = 2; i < 100; ++i) {
    AddPart(Part(7, static_cast<uint64_t>(i), {}, {100 + i}), kMany, track);
  }
  EXPECT_THAT(FindRun(track, 7)->lost_frames_ns, ElementsAre(10, 30, 60, 80, 102, 199));
}

TEST(LocalisedTrackTest, ALongTrajectoryIsCoarserTheOlderItIsAndKeepsItsGaps) {
  LocalisedTrack track;
  AddPart(Part(7, 1, {1, 2, 3, 4, 6, 7, 8}, {5}), 8, track);
  EXPECT_EQ(track.dropped, 0u);
  AddPart(Part(7, 2, {9, 10}), 8, track);
  EXPECT_THAT(TimesOf(track.runs[0]), ElementsAre(1, 3, 6, 8, 10));
  EXPECT_THAT(track.runs[0].lost_frames_ns, ElementsAre(5));
  EXPECT_EQ(track.dropped, 4u);
  AddPart(Part(7, 3, {11, 12, 13, 14}), 8, track);
  EXPECT_THAT(TimesOf(track.runs[0]), ElementsAre(1, 6, 10, 12, 14));
  EXPECT_EQ(CountFrames(track) + track.dropped, 13u);
}

// A camera that is lost at each second frame for long would fill what no frame does.
TEST(LocalisedTrackTest, LossesAreBoundedToo) {
  LocalisedTrack track;
  for (int64_t i = 0; i < 1000; ++i) {
    AddPart(Part(7, static_cast<uint64_t>(i + 1), {4 * i}, {4 * i + 1, 4 * i + 2}), 16, track);
  }
  EXPECT_LE(CountFrames(track), 16u);
  EXPECT_LE(track.runs[0].lost_frames_ns.size(), 40u);
  EXPECT_EQ(track.runs[0].frames.front().timestamp_ns, 0);
}

TEST(LocalisedTrackTest, TimesThatFallBackAreBoundedToo) {
  LocalisedTrack track;
  AddPart(Part(7, 1, {1'000'000}), 16, track);
  for (uint64_t number = 2; number < 12; ++number) {
    std::vector<int64_t> falling;
    for (int64_t i = 1000; i > 0; --i) falling.push_back(i);
    AddPart(Part(7, number, {}, falling), 16, track);
  }
  EXPECT_LE(track.runs[0].lost_frames_ns.size(), 4u);
  EXPECT_FALSE(track.runs[0].lost_frames_ns.empty());
}

TEST(LocalisedTrackTest, RunsWithoutAPoseGoAndTheOldestBeyondTheLimit) {
  LocalisedTrack track;
  AddPart(Part(1, 1, {}, {5}), kMany * 10, track);
  for (uint64_t run = 2; run < kMaxLocalisedRuns + 3; ++run) {
    AddPart(Part(run, 1, {1, 2}), kMany * 10, track);
  }
  EXPECT_EQ(FindRun(track, 1), nullptr);
  EXPECT_EQ(track.runs.size(), kMaxLocalisedRuns);
  EXPECT_EQ(track.runs.front().id, 3u);
  EXPECT_EQ(track.dropped, 2u);
}

TEST(LocalisedTrackTest, OfEachRunTheFirstFrameStays) {
  LocalisedTrack track;
  for (uint64_t run = 1; run <= 5; ++run) AddPart(Part(run, 1, {1, 2, 3}), 3, track);
  EXPECT_EQ(CountFrames(track), 5u);
  EXPECT_THAT(track.runs[0].lost_frames_ns, IsEmpty());
}

}  // namespace
}  // namespace corbslam::map_store
