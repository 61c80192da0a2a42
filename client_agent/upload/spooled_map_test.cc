// Tests what is refused of a local map that was spooled. That the rest is as the store has it, the
// recorder's test says.
#include "client_agent/upload/spooled_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "client_agent/spool/testing/fake_spool.h"
#include "client_agent/upload/spooled_map_reading.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kSpooled{7};

FullKeyframe MakeSpooledKeyframe(uint32_t index, KeyframeId parent = {}) {
  Features features;
  features.keypoints.resize(4);
  features.descriptors.resize(4);
  return {
      MakeKeyframePayload({kSpooled, index}, index, 0, testing::TestCamera(), std::move(features)),
      Rigid3d::Identity(), parent};
}

MapUpdateBatch FirstBatch() {
  MapUpdateBatch batch;
  batch.local_map = kSpooled;
  batch.number = 1;
  batch.cameras.push_back(testing::TestCamera());
  batch.full_keyframes.push_back(MakeSpooledKeyframe(0));
  batch.full_keyframes.push_back(MakeSpooledKeyframe(1, {kSpooled, 0}));
  FullMapPoint point;
  point.id = {kSpooled, 0};
  point.reference = {kSpooled, 0};
  point.position_in_local = {0, 0, 5};
  point.normal_in_local = {0, 0, 1};
  batch.full_points.push_back(point);
  batch.observations.push_back({ObservationChange::Kind::kAdded, {kSpooled, 0}, {kSpooled, 0}, 2});
  return batch;
}

std::string WhyNot(const MapUpdateBatch& batch) {
  SpooledMap spooled_map(kSpooled);
  absl::Status status = spooled_map.Apply(batch);
  if (status.ok()) status = spooled_map.Check();
  EXPECT_TRUE(absl::IsInvalidArgument(status) || absl::IsPermissionDenied(status)) << status;
  return std::string(status.message());
}

TEST(SpooledMapTest, AMapIsMadeOfIt) {
  SpooledMap spooled_map(kSpooled);
  ASSERT_TRUE(spooled_map.Apply(FirstBatch()).ok());
  ASSERT_TRUE(spooled_map.Check().ok());
  Map map;
  spooled_map.Fill([](const auto&) { return std::make_shared<const Words>(); }, map);
  ASSERT_EQ(map.keyframes().size(), 2u);
  EXPECT_EQ(map.FindKeyframe({kSpooled, 0})->points[2], (MapPointId{kSpooled, 0}));
  EXPECT_TRUE(map.FindKeyframe({kSpooled, 0})->children.contains({kSpooled, 1}));
  EXPECT_NE(map.FindKeyframe({kSpooled, 1})->words, nullptr);
  EXPECT_EQ(spooled_map.next_keyframe(), 2u);
  EXPECT_EQ(spooled_map.next_point(), 1u);
}

TEST(SpooledMapTest, WhatDoesNotFitIsRefusedByName) {
  MapUpdateBatch batch;
  batch.local_map = kSpooled;
  EXPECT_THAT(WhyNot(batch), HasSubstr("no keyframe"));
  batch = FirstBatch();
  batch.cameras.clear();
  EXPECT_THAT(WhyNot(batch), HasSubstr("camera 0 was never told"));
  batch = FirstBatch();
  batch.full_keyframes[1].parent = KeyframeId();
  EXPECT_THAT(WhyNot(batch), HasSubstr("hang on no other"));
  batch = FirstBatch();
  batch.full_keyframes[1].parent = {kSpooled, 9};
  EXPECT_THAT(WhyNot(batch), HasSubstr("is not in the map"));
  batch = FirstBatch();
  batch.full_keyframes[0].parent = {kSpooled, 1};
  EXPECT_THAT(WhyNot(batch), HasSubstr("hangs on itself"));
  batch = FirstBatch();
  batch.observations[0].keypoint = 4;
  EXPECT_THAT(WhyNot(batch), HasSubstr("no such keypoint"));
  batch = FirstBatch();
  batch.observations[0].point = {kSpooled, 5};
  EXPECT_THAT(WhyNot(batch), HasSubstr("observed point"));
  batch = FirstBatch();
  batch.light_keyframes.push_back({{kSpooled, 8}, Rigid3d::Identity(), {}});
  EXPECT_THAT(WhyNot(batch), HasSubstr("is not in the map"));
  batch = FirstBatch();
  batch.full_points[0].position_in_local.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(WhyNot(batch), HasSubstr("position"));
  batch = FirstBatch();
  batch.local_map = LocalMapId{8};
  EXPECT_THAT(WhyNot(batch), HasSubstr("the batch is of local map"));
}

class SpooledMapReadingTest : public ::testing::Test {
 protected:
  void Write(uint64_t number, bool closes = false, LocalMapId local_map = kSpooled) {
    MapUpdateBatch batch = number == 1 && local_map == kSpooled ? FirstBatch() : MapUpdateBatch();
    batch.local_map = local_map;
    batch.number = number;
    batch.lost_frames_ns = {1};
    batch.closes_local_map = closes;
    ASSERT_TRUE(spool_->Append(batch).ok());
  }
  absl::StatusOr<SpooledMap> Read() {
    spool_ = *OpenFakeSpool(&disk_);
    return ReadNewestSpooledMap(*spool_);
  }

  FakeDisk disk_;
  std::unique_ptr<Spool> spool_ = *OpenFakeSpool(&disk_);
};

TEST_F(SpooledMapReadingTest, TheNewestThatIsOpenIsRead) {
  Write(1, /*closes=*/true, LocalMapId{5});
  Write(1);
  Write(2);
  const auto spooled_map = Read();
  ASSERT_TRUE(spooled_map.ok()) << spooled_map.status();
  EXPECT_EQ(spooled_map->local_map(), kSpooled);
  EXPECT_EQ(spooled_map->keyframes().size(), 2u);
}

TEST_F(SpooledMapReadingTest, NothingIsKeptOfWhatIsClosed) {
  Write(1);
  Write(2, /*closes=*/true);
  EXPECT_TRUE(absl::IsNotFound(Read().status()));
}

TEST_F(SpooledMapReadingTest, ABatchThatIsMissingIsNamed) {
  Write(1);
  Write(3);
  EXPECT_THAT(std::string(Read().status().message()), HasSubstr("no batch 2"));
}

TEST_F(SpooledMapReadingTest, WhereItWasNotKeptThatIsSaid) {
  Write(4);
  EXPECT_THAT(std::string(Read().status().message()), HasSubstr("--resume"));
}

TEST_F(SpooledMapReadingTest, ASnapshotStandsForTheBatchesBefore) {
  Write(3);
  SpooledMap spooled_map(kSpooled);
  ASSERT_TRUE(spooled_map.Apply(FirstBatch()).ok());
  std::vector<MapUpdateBatch> parts = spooled_map.ToBatches(1, 1);
  ASSERT_GT(parts.size(), 1u);
  for (MapUpdateBatch& part : parts) {
    part.number = 2;
    const bool last = &part == &parts.back();
    ASSERT_TRUE(spool_
                    ->Append(part, last ? SpoolRecord::Kind::kSnapshotEnd
                                        : SpoolRecord::Kind::kSnapshotPart)
                    .ok());
  }
  const auto read = Read();
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->keyframes().size(), 2u);
}

TEST_F(SpooledMapReadingTest, HalfASnapshotIsNone) {
  Write(3);
  MapUpdateBatch part = FirstBatch();
  part.number = 2;
  ASSERT_TRUE(spool_->Append(part, SpoolRecord::Kind::kSnapshotPart).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(Read().status()));
}

}  // namespace
}  // namespace corbslam::client_agent
