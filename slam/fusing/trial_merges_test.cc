#include "slam/fusing/trial_merges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr KeyframeId K(uint32_t index) { return {{0xa}, index}; }
constexpr MapPointId P(uint32_t index) { return {{0xa}, index}; }

const Eigen::Vector3d kSurvivorBefore(1, 2, 3);
const Eigen::Vector3d kMemberBefore(4, 5, 6);
const Eigen::Vector3d kAdjusted(7, 8, 9);
const Eigen::Vector3d kStep(0.5, 0, 0);

// Keyframes 0 to 3, none turned, at the origin. Point 0 is seen by 0 and 1, point 1 by 2 and 3.
class TrialMergesTest : public ::testing::Test {
 protected:
  TrialMergesTest() {
    AddPoint(P(0), kSurvivorBefore);
    AddPoint(P(1), kMemberBefore);
    for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i, P(i / 2));
    trial_ = *MergeOnTrial({P(0), P(1)}, map_);
  }

  void AddPoint(MapPointId id, const Eigen::Vector3d& position) {
    MapPoint point;
    point.id = id;
    point.position_in_map = position;
    map_.AddPoint(point);
  }
  void AddKeyframe(uint32_t index, MapPointId seen) {
    auto camera = std::make_shared<Camera>();
    *camera = {500, 500, 320, 240, 640, 480, 0.1, 4};
    Features features;
    features.keypoints.resize(1);
    features.descriptors.resize(1);
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(K(index), index, 0, camera, features);
    map_.AddKeyframe(std::move(keyframe));
    map_.AddObservation(seen, K(index), 0);
  }

  // All keyframes, and what they see, went kStep on; the merged point somewhere else.
  WeldingResult JudgeWithOutliers(const std::vector<uint32_t>& keyframes) const {
    BundleResult adjusted;
    for (uint32_t i = 0; i < 4; ++i) {
      adjusted.poses.push_back({K(i), {Eigen::Quaterniond::Identity(), -kStep}});
    }
    adjusted.positions.push_back({P(0), kAdjusted});
    for (const uint32_t i : keyframes) adjusted.outliers.push_back({P(0), K(i)});
    return JudgeMerges({trial_}, map_, adjusted);
  }

  Map map_;
  TrialMerge trial_;
};

TEST_F(TrialMergesTest, TheMapHasOnePointOfTheTwo) {
  EXPECT_EQ(map_.FindPoint(P(1)), nullptr);
  EXPECT_THAT(map_.FindPoint(P(0))->observations, SizeIs(4));
}

TEST_F(TrialMergesTest, NothingIsMergedWithWhatIsNotThere) {
  EXPECT_FALSE(MergeOnTrial({P(0), P(7)}, map_).has_value());
  EXPECT_FALSE(MergeOnTrial({P(7), P(0)}, map_).has_value());
  EXPECT_FALSE(MergeOnTrial({P(0), P(0)}, map_).has_value());
  EXPECT_THAT(map_.FindPoint(P(0))->observations, SizeIs(4));
}

TEST_F(TrialMergesTest, WhatBothSidesAgreeWithIsOne) {
  const WeldingResult result = JudgeWithOutliers({});
  ASSERT_THAT(result.merges, SizeIs(1));
  EXPECT_EQ(result.merges[0].survivor, P(0));
  EXPECT_EQ(result.merges[0].member, P(1));
  EXPECT_THAT(result.positions, ElementsAre(Pair(P(0), kAdjusted)));
  EXPECT_THAT(result.rejected, IsEmpty());
}

TEST_F(TrialMergesTest, HalfOfWhatSeesASideMayBeOutliers) {
  const WeldingResult result = JudgeWithOutliers({1, 2});
  EXPECT_THAT(result.merges, SizeIs(1));
  ASSERT_THAT(result.rejected, SizeIs(2));
  EXPECT_EQ(result.rejected[0].keyframe, K(1));
  EXPECT_EQ(result.rejected[1].keyframe, K(2));
}

TEST_F(TrialMergesTest, AMemberWhoseObserversAreOutliersIsAPointOfItsOwn) {
  const WeldingResult result = JudgeWithOutliers({2, 3});
  EXPECT_THAT(result.merges, IsEmpty());
  EXPECT_THAT(result.rejected, IsEmpty());
  EXPECT_THAT(result.positions,
              UnorderedElementsAre(Pair(P(0), kAdjusted), Pair(P(1), kMemberBefore + kStep)));
}

TEST_F(TrialMergesTest, ASurvivorWhoseObserversAreOutliersGoesAlongWithThem) {
  const WeldingResult result = JudgeWithOutliers({0, 1, 3});
  EXPECT_THAT(result.merges, IsEmpty());
  EXPECT_THAT(result.rejected, IsEmpty());
  EXPECT_THAT(result.positions,
              UnorderedElementsAre(Pair(P(0), kSurvivorBefore + kStep), Pair(P(1), kAdjusted)));
}

TEST_F(TrialMergesTest, ASurvivorThatIsHeldStays) {
  BundleResult adjusted;
  for (const uint32_t i : {2u, 3u}) {
    adjusted.poses.push_back({K(i), {Eigen::Quaterniond::Identity(), -kStep}});
    adjusted.outliers.push_back({P(0), K(i)});
  }
  const WeldingResult result = JudgeMerges({trial_}, map_, adjusted);
  EXPECT_THAT(result.merges, IsEmpty());
  EXPECT_THAT(result.positions, ElementsAre(Pair(P(1), kMemberBefore + kStep)));
}

}  // namespace
}  // namespace corbslam
