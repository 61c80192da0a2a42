#include "slam/fusing/redundant_keyframes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr KeyframeId K(uint32_t index) { return {{0xa}, index}; }
constexpr MapPointId P(uint32_t index) { return {{0xa}, index}; }

// Each keyframe is the child of the one before, with one keypoint a point.
class RedundantKeyframesTest : public ::testing::Test {
 protected:
  void AddKeyframe(uint32_t index, const std::vector<uint32_t>& points, uint8_t octave = 0) {
    auto camera = std::make_shared<Camera>();
    *camera = {500, 500, 320, 240, 640, 480, 0.1, 4};
    Features features;
    features.keypoints.resize(points.size());
    for (Keypoint& keypoint : features.keypoints) keypoint.octave = octave;
    features.descriptors.resize(points.size());
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(K(index), index, 0, camera, features);
    if (index > 0) keyframe.parent = K(index - 1);
    map_.AddKeyframe(std::move(keyframe));
    for (uint32_t i = 0; i < points.size(); ++i) {
      MapPoint point;
      point.id = P(points[i]);
      map_.AddPoint(point);
      map_.AddObservation(P(points[i]), K(index), i);
    }
  }
  std::vector<KeyframeId> Find(const RedundancyOptions& options,
                               const absl::btree_set<KeyframeId>& kept = {}) const {
    return FindRedundantKeyframes(map_, kept, options);
  }

  Map map_;
};

TEST_F(RedundantKeyframesTest, OneThatThreeOthersCoverGoes) {
  for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i, {1, 2, 3, 4, 5, 6, 7, 8, 9, i * 100 + 10});
  // The first is the root; when one has gone, two others are left beside each.
  EXPECT_THAT(Find({.seen_share = 0.9}), SizeIs(1));
  EXPECT_THAT(Find({.seen_share = 0.95}), IsEmpty()) << "a tenth of each is its own";
  EXPECT_THAT(Find({}), IsEmpty());
}

TEST_F(RedundantKeyframesTest, KeptOnesStay) {
  for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i, {1, 2, 3, 4});
  EXPECT_THAT(Find({.seen_share = 0.9}, {K(2), K(3)}), ElementsAre(K(1)));
  EXPECT_THAT(Find({.seen_share = 0.9}, {K(1), K(2), K(3)}), IsEmpty());
}

TEST_F(RedundantKeyframesTest, CoarserSightsDoNotReplaceAFineOne) {
  AddKeyframe(0, {1, 2, 3, 4}, 4);
  AddKeyframe(1, {1, 2, 3, 4}, 0);
  AddKeyframe(2, {1, 2, 3, 4}, 4);
  AddKeyframe(3, {1, 2, 3, 4}, 4);
  AddKeyframe(4, {1, 2, 3, 4}, 4);
  const std::vector<KeyframeId> redundant = Find({.seen_share = 0.9});
  EXPECT_THAT(redundant, SizeIs(2));
  EXPECT_THAT(redundant, ::testing::Not(::testing::Contains(K(1))));
}

TEST_F(RedundantKeyframesTest, ATargetTakesTheMostRedundantFirst) {
  for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i, {1, 2, 3, 4});
  for (uint32_t i = 4; i < 8; ++i) AddKeyframe(i, {i * 10, i * 10 + 1});
  AddKeyframe(8, {});
  EXPECT_THAT(Find({.target_keyframes = 9}), IsEmpty());
  const std::vector<KeyframeId> redundant = Find({.target_keyframes = 7});
  ASSERT_THAT(redundant, SizeIs(2));
  EXPECT_LT(redundant[0].index, 4u);
  // The root and the one that sees nothing never go.
  EXPECT_THAT(Find({.target_keyframes = 1}), SizeIs(7));
}

}  // namespace
}  // namespace corbslam
