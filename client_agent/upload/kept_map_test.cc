// What is refused of a local map that was kept. That the rest is as the store has it, the recorder's
// test says.
#include "client_agent/upload/kept_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "client_agent/spool/testing/fake_spool.h"
#include "client_agent/upload/kept_map_reading.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kKept{7};

FullKeyframe KeptKeyframe(uint32_t index, KeyframeId parent = {}) {
  Features features;
  features.keypoints.resize(4);
  features.descriptors.resize(4);
  return {MakeKeyframePayload({kKept, index}, index, 0, testing::TestCamera(),
                              std::move(features)),
          Rigid3d::Identity(), parent};
}

MapUpdateBatch FirstBatch() {
  MapUpdateBatch batch;
  batch.local_map = kKept;
  batch.number = 1;
  batch.cameras.push_back(testing::TestCamera());
  batch.full_keyframes.push_back(KeptKeyframe(0));
  batch.full_keyframes.push_back(KeptKeyframe(1, {kKept, 0}));
  FullMapPoint point;
  point.id = {kKept, 0};
  point.reference = {kKept, 0};
  point.position_in_local = {0, 0, 5};
  point.normal_in_local = {0, 0, 1};
  batch.full_points.push_back(point);
  batch.observations.push_back({ObservationChange::Kind::kAdded, {kKept, 0}, {kKept, 0}, 2});
  return batch;
}

std::string WhyNot(const MapUpdateBatch& batch) {
  KeptMap kept(kKept);
  absl::Status status = kept.Apply(batch);
  if (status.ok()) status = kept.Check();
  EXPECT_TRUE(absl::IsInvalidArgument(status) || absl::IsPermissionDenied(status)) << status;
  return std::string(status.message());
}

TEST(KeptMapTest, AMapIsMadeOfIt) {
  KeptMap kept(kKept);
  ASSERT_TRUE(kept.Apply(FirstBatch()).ok());
  ASSERT_TRUE(kept.Check().ok());
  Map map;
  kept.Fill([](const auto&) { return std::make_shared<const Words>(); }, map);
  ASSERT_EQ(map.keyframes().size(), 2u);
  EXPECT_EQ(map.FindKeyframe({kKept, 0})->points[2], (MapPointId{kKept, 0}));
  EXPECT_TRUE(map.FindKeyframe({kKept, 0})->children.contains({kKept, 1}));
  EXPECT_NE(map.FindKeyframe({kKept, 1})->words, nullptr);
  EXPECT_EQ(kept.next_keyframe(), 2u);
  EXPECT_EQ(kept.next_point(), 1u);
}

TEST(KeptMapTest, WhatDoesNotFitIsRefusedByName) {
  MapUpdateBatch batch;
  batch.local_map = kKept;
  EXPECT_THAT(WhyNot(batch), HasSubstr("no keyframe"));
  batch = FirstBatch();
  batch.cameras.clear();
  EXPECT_THAT(WhyNot(batch), HasSubstr("camera 0 was never told"));
  batch = FirstBatch();
  batch.full_keyframes[1].parent = KeyframeId();
  EXPECT_THAT(WhyNot(batch), HasSubstr("hang on no other"));
  batch = FirstBatch();
  batch.full_keyframes[1].parent = {kKept, 9};
  EXPECT_THAT(WhyNot(batch), HasSubstr("is not in the map"));
  batch = FirstBatch();
  batch.full_keyframes[0].parent = {kKept, 1};
  EXPECT_THAT(WhyNot(batch), HasSubstr("hangs on itself"));
  batch = FirstBatch();
  batch.observations[0].keypoint = 4;
  EXPECT_THAT(WhyNot(batch), HasSubstr("no such keypoint"));
  batch = FirstBatch();
  batch.observations[0].point = {kKept, 5};
  EXPECT_THAT(WhyNot(batch), HasSubstr("observed point"));
  batch = FirstBatch();
  batch.light_keyframes.push_back({{kKept, 8}, Rigid3d::Identity(), {}});
  EXPECT_THAT(WhyNot(batch), HasSubstr("is not in the map"));
  batch = FirstBatch();
  batch.full_points[0].position_in_local.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(WhyNot(batch), HasSubstr("position"));
  batch = FirstBatch();
  batch.local_map = LocalMapId{8};
  EXPECT_THAT(WhyNot(batch), HasSubstr("the batch is of local map"));
}

class KeptReadingTest : public ::testing::Test {
 protected:
  void Write(uint64_t number, bool closes = false, LocalMapId local_map = kKept) {
    MapUpdateBatch batch = number == 1 && local_map == kKept ? FirstBatch() : MapUpdateBatch();
    batch.local_map = local_map;
    batch.number = number;
    batch.lost_frames_ns = {1};
    batch.closes_local_map = closes;
    ASSERT_TRUE(spool_->Append(batch).ok());
  }
  absl::StatusOr<KeptMap> Read() {
    spool_ = *OpenFakeSpool(&disk_);
    return ReadNewestKeptMap(*spool_);
  }

  FakeDisk disk_;
  std::unique_ptr<Spool> spool_ = *OpenFakeSpool(&disk_);
};

TEST_F(KeptReadingTest, TheNewestThatIsOpenIsRead) {
  Write(1, /*closes=*/true, LocalMapId{5});
  Write(1);
  Write(2);
  const auto kept = Read();
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->local_map(), kKept);
  EXPECT_EQ(kept->keyframes().size(), 2u);
}

TEST_F(KeptReadingTest, NothingIsKeptOfWhatIsClosed) {
  Write(1);
  Write(2, /*closes=*/true);
  EXPECT_TRUE(absl::IsNotFound(Read().status()));
}

TEST_F(KeptReadingTest, ABatchThatIsMissingIsNamed) {
  Write(1);
  Write(3);
  EXPECT_THAT(std::string(Read().status().message()), HasSubstr("no batch 2"));
}

TEST_F(KeptReadingTest, WhereItWasNotKeptThatIsSaid) {
  Write(4);
  EXPECT_THAT(std::string(Read().status().message()), HasSubstr("--resume"));
}

TEST_F(KeptReadingTest, AWholeStandsForTheBatchesBefore) {
  Write(3);
  KeptMap kept(kKept);
  ASSERT_TRUE(kept.Apply(FirstBatch()).ok());
  std::vector<MapUpdateBatch> parts = kept.ToBatches(1, 1);
  ASSERT_GT(parts.size(), 1u);
  for (MapUpdateBatch& part : parts) {
    part.number = 2;
    const bool last = &part == &parts.back();
    ASSERT_TRUE(spool_
                    ->Append(part, last ? SpoolRecord::Kind::kWholeEnd
                                        : SpoolRecord::Kind::kWholePart)
                    .ok());
  }
  const auto read = Read();
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->keyframes().size(), 2u);
}

TEST_F(KeptReadingTest, HalfAWholeIsNone) {
  Write(3);
  MapUpdateBatch part = FirstBatch();
  part.number = 2;
  ASSERT_TRUE(spool_->Append(part, SpoolRecord::Kind::kWholePart).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(Read().status()));
}

}  // namespace
}  // namespace corbslam::client_agent
