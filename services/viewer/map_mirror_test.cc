#include "services/viewer/map_mirror.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "services/viewer/testing/map_changes.h"

namespace corbslam::services {
namespace {

using testing::ChangesWriter;
using ::testing::HasSubstr;
using testing::kFirst;
using testing::kSecond;
using ::testing::Not;

// Returns all there is of the mirror, as one message.
std::string Everything(const MapMirror& mirror) {
  PictureCursor cursor;
  v1::WatchMapResponse piece = mirror.NextPiece(true, SIZE_MAX, cursor);
  EXPECT_TRUE(cursor.ended);
  piece.clear_version();
  return piece.DebugString();
}

TEST(MapMirrorTest, KeepsWhatCameAndForgetsWhatWent) {
  MapMirror mirror;
  ASSERT_TRUE(mirror
                  .Apply(ChangesWriter(1)
                             .Island(kFirst, {kFirst}, /*anew=*/true)
                             .Keyframe({kFirst, 0}, 1.0)
                             .Keyframe({kFirst, 1}, 2.0)
                             .Point({kFirst, 7}, 3.0F)
                             .Take())
                  .ok());
  EXPECT_EQ(mirror.keyframes(), 2U);
  EXPECT_EQ(mirror.points(), 1U);
  ASSERT_TRUE(mirror
                  .Apply(ChangesWriter(2)
                             .Island(kFirst, {kFirst}, /*anew=*/false)
                             .Keyframe({kFirst, 1}, 5.0)
                             .RemoveKeyframe({kFirst, 0})
                             .RemovePoint({kFirst, 7})
                             .Take())
                  .ok());
  EXPECT_EQ(mirror.keyframes(), 1U);
  EXPECT_EQ(mirror.points(), 0U);
  EXPECT_EQ(mirror.version(), 2U);
  EXPECT_THAT(Everything(mirror), HasSubstr("translation: 5"));
}

TEST(MapMirrorTest, PassesOnHowManyKeyframesSeeAPoint) {
  MapMirror mirror;
  v1::WatchMapResponse told =
      ChangesWriter(1).Island(kFirst, {kFirst}, /*anew=*/true).Point({kFirst, 7}, 3.0F).Take();
  ASSERT_TRUE(mirror.Apply(told).ok());
  EXPECT_THAT(Everything(mirror), Not(HasSubstr("point_observations"))) << "an older store";
  told.mutable_islands(0)->add_point_observations(4);
  ASSERT_TRUE(mirror.Apply(told).ok());
  EXPECT_THAT(Everything(mirror), HasSubstr("point_observations: 4"));
  told.mutable_islands(0)->add_point_observations(5);
  EXPECT_THAT(std::string(mirror.Apply(told).message()),
              HasSubstr("point_observations has 2 numbers for 1 points"));
}

TEST(MapMirrorTest, IslandsMergeAndBeginAnew) {
  MapMirror mirror;
  ASSERT_TRUE(mirror
                  .Apply(ChangesWriter(1)
                             .Island(kFirst, {kFirst}, true)
                             .Keyframe({kFirst, 0}, 1.0)
                             .Island(kSecond, {kSecond}, true)
                             .Keyframe({kSecond, 0}, 1.0)
                             .Point({kSecond, 0}, 1.0F)
                             .Take())
                  .ok());
  ASSERT_TRUE(mirror
                  .Apply(ChangesWriter(2)
                             .Remove(kSecond)
                             .Island(kFirst, {kFirst, kSecond}, true)
                             .Keyframe({kFirst, 0}, 1.0)
                             .Keyframe({kSecond, 0}, 8.0)
                             .Take())
                  .ok());
  EXPECT_EQ(mirror.keyframes(), 2U);
  EXPECT_EQ(mirror.points(), 0U);
}

TEST(MapMirrorTest, RefusesWhatCantBeRead) {
  v1::WatchMapResponse changes =
      ChangesWriter(1).Island(kFirst, {kFirst}, true).Point({kFirst, 0}, 1.0F).Take();
  changes.mutable_islands(0)->mutable_points()->add_positions(1.0F);
  EXPECT_THAT(MapMirror().Apply(changes).message(), HasSubstr("positions has 4 numbers"));
  changes = ChangesWriter(1).Island(kFirst, {kFirst}, true).Take();
  changes.mutable_islands(0)->set_slot(9);
  EXPECT_EQ(MapMirror().Apply(changes).code(), absl::StatusCode::kInvalidArgument);
}

// A mission's life at random: what is known of it must be the same to somebody who was told a
// picture in pieces, and in between and behind it all changes since its beginning.
class PictureTest : public ::testing::TestWithParam<int> {};

TEST_P(PictureTest, APictureAndTheChangesSinceMakeTheSameMap) {
  std::mt19937 random(static_cast<uint32_t>(GetParam()));
  testing::RandomChanges changes(GetParam());
  MapMirror mirror;
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(mirror.Apply(changes.Next()).ok());

  MapMirror told;
  std::vector<v1::WatchMapResponse> since;
  PictureCursor cursor;
  const size_t items = 1 + random() % 40;
  while (!cursor.ended) {
    ASSERT_TRUE(told.Apply(mirror.NextPiece(true, items, cursor)).ok());
    if (random() % 3 == 0) {
      since.push_back(changes.Next());
      ASSERT_TRUE(mirror.Apply(since.back()).ok());
    }
  }
  for (const v1::WatchMapResponse& change : since) ASSERT_TRUE(told.Apply(change).ok());
  EXPECT_EQ(Everything(told), Everything(mirror));
  EXPECT_EQ(told.keyframes(), mirror.keyframes());
  EXPECT_EQ(told.points(), mirror.points());
}

TEST_P(PictureTest, PiecesAreBounded) {
  testing::RandomChanges changes(GetParam());
  MapMirror mirror;
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(mirror.Apply(changes.Next()).ok());
  PictureCursor cursor;
  size_t keyframes = 0;
  while (!cursor.ended) {
    const v1::WatchMapResponse piece = mirror.NextPiece(false, 7, cursor);
    size_t items = 0;
    for (const auto& island : piece.islands()) {
      items += static_cast<size_t>(island.keyframes_size());
      EXPECT_EQ(island.points().ids().index_deltas_size(), 0);
    }
    EXPECT_LE(items, 7U);
    keyframes += items;
  }
  EXPECT_EQ(keyframes, mirror.keyframes());
}

INSTANTIATE_TEST_SUITE_P(Lives, PictureTest, ::testing::Range(1, 41),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace corbslam::services
