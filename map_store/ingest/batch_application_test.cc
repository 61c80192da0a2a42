// Tests what becomes of points when keyframes move.
#include "map_store/ingest/batch_application.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <variant>

#include "map_store/archive/record_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/testing/small_mission_state.h"

namespace corbslam::map_store {
namespace {

const Rigid3d kMotion = {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                         {1, 0.2, -2}};

class PointsFollowTest : public corbslam::testing::SmallMissionState {
 protected:
  // Returns a batch in which the reference moves as if the world had been moved by kMotion.
  MapUpdateBatch ReferenceMoves(bool points_follow) const {
    const Rigid3d before = state_.FindLocalMap(kMap)->map.FindKeyframe(kReference)->camera_from_map;
    MapUpdateBatch batch;
    batch.light_keyframes = {{kReference, before * kMotion.Inverse(), {}}};
    batch.points_follow = points_follow;
    return batch;
  }
  Eigen::Vector3d Position(MapPointId id) const {
    return state_.FindLocalMap(kMap)->map.FindPoint(id)->position_in_map;
  }
};

TEST_F(PointsFollowTest, TheirReferenceWhereTheAgentSaysSo) {
  const Eigen::Vector3d before = Position(kPoint);
  ApplyNext(ReferenceMoves(/*points_follow=*/false));
  EXPECT_EQ(Position(kPoint), before);
  ApplyNext(ReferenceMoves(/*points_follow=*/true));
  EXPECT_LT((Position(kPoint) - kMotion * before).norm(), 1e-12);
}

TEST_F(PointsFollowTest, ButNotAnotherKeyframe) {
  const Eigen::Vector3d before = Position(kPoint);
  MapUpdateBatch batch = ReferenceMoves(true);
  batch.light_keyframes[0].id = {kMap, 1};
  ApplyNext(batch);
  EXPECT_EQ(Position(kPoint), before);
}

TEST_F(PointsFollowTest, AndThenGoWhereTheyAreSaidToBe) {
  const Eigen::Vector3d other_before = Position(kOther);
  MapUpdateBatch batch = ReferenceMoves(true);
  batch.light_points = {{kPoint, {3, 2, 1}}};
  ApplyNext(batch);
  EXPECT_EQ(Position(kPoint), Eigen::Vector3d(3, 2, 1));
  EXPECT_LT((Position(kOther) - kMotion * other_before).norm(), 1e-12);
}

TEST_F(PointsFollowTest, AndStayWhenItIsGone) {
  const Eigen::Vector3d before = Position(kPoint);
  MapUpdateBatch removal;
  removal.removed_keyframes = {{kReference, {kMap, 1}, {}}};
  ApplyNext(removal);
  MapUpdateBatch late = removal;
  late.removed_keyframes.clear();
  late.light_keyframes = {{kReference, kMotion, {}}};
  late.points_follow = true;
  ApplyNext(late);
  EXPECT_EQ(Position(kPoint), before);
}

TEST_F(PointsFollowTest, AlsoAfterARestart) {
  const Eigen::Vector3d before = Position(kPoint);
  auto restored = DecodeState(EncodeState(state_), [](KeyframeId) -> absl::StatusOr<Features> {
    return corbslam::testing::MakeSmallFeatures();
  });
  ASSERT_TRUE(restored.ok()) << restored.status();
  state_ = *std::move(restored);
  ApplyNext(ReferenceMoves(true));
  EXPECT_LT((Position(kPoint) - kMotion * before).norm(), 1e-12);
}

TEST_F(PointsFollowTest, AsTheirJournalRecordSays) {
  MapUpdateBatch batch = ReferenceMoves(true);
  batch.local_map = kMap;
  const JournalRecord record =
      BatchRecord{"a", std::make_shared<const MapUpdateBatch>(batch), absl::Time()};
  const auto read = DecodeRecord(EncodeRecord(record), nullptr);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_TRUE(std::get<BatchRecord>(*read).batch->points_follow);
}

}  // namespace
}  // namespace corbslam::map_store
