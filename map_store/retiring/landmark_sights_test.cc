#include "map_store/retiring/landmark_sights.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kThen{1};
constexpr LocalMapId kNow{2};
constexpr MapPointId kLandmark{kThen, 0};
constexpr KeyframeId kWitness{kThen, 0};
constexpr KeyframeId kLater{kNow, 0};

// A landmark 10 m before two cameras that stand in one place. One sees it; what the other sees is
// for the test to say.
class LandmarkSightsTest : public ::testing::Test {
 protected:
  void Add(KeyframeId id, const Features& features) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(id, 0, 0, camera_, features);
    view_.map.AddKeyframe(std::move(keyframe));
    view_.poses[id] = Similarity3d();
    view_.closed[id.local_map] = {id.local_map, view_.closed.size(), 1, 1};
  }
  LandmarkSights Find(const Features& later) {
    Add(kWitness, Seen(320, 10, descriptor_));
    Add(kLater, later);
    MapPoint point;
    point.id = kLandmark;
    point.position_in_map = {0, 0, 10};
    view_.map.AddPoint(std::move(point));
    view_.map.AddObservation(kLandmark, kWitness, 0);
    view_.map.UpdatePointAppearance(kLandmark);
    view_.landmarks[kLandmark] = {kLandmark};
    return FindSights(view_, {}).at(kLandmark);
  }
  // Returns one keypoint of the picture's middle line.
  static Features Seen(float x_px, float depth_m, const Descriptor& descriptor) {
    Features features;
    features.keypoints.push_back({x_px, 240, 500 * 0.1f / depth_m, 0, 0});
    features.descriptors.push_back(descriptor);
    return features;
  }
  static bool IsMissed(const LandmarkSights& sights) { return !sights.missed_by.empty(); }

  const std::shared_ptr<const Camera> camera_ =
      std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4});
  const Descriptor descriptor_{{1, 2, 3, 4}};
  const Descriptor other_{{~0ull, ~0ull, ~0ull, ~0ull}};
  RetiringView view_;
};

TEST_F(LandmarkSightsTest, AKeypointThatNobodyMatchedIsASight) {
  const LandmarkSights sights = Find(Seen(322, 10, descriptor_));
  ASSERT_EQ(sights.seen.size(), 2u);
  EXPECT_EQ(sights.seen[1].keyframe, kLater);
  EXPECT_FALSE(sights.seen[1].observed);
  EXPECT_TRUE(sights.seen[0].observed);
  EXPECT_FALSE(IsMissed(sights));
}

TEST_F(LandmarkSightsTest, WhereSomethingElseIsSeenThroughItItIsMissed) {
  const LandmarkSights sights = Find(Seen(322, 12, other_));
  EXPECT_EQ(sights.seen.size(), 1u);
  ASSERT_EQ(sights.missed_by.size(), 1u);
  EXPECT_EQ(sights.missed_by[0], kLater);
}

TEST_F(LandmarkSightsTest, WhatStandsBeforeItHidesIt) {
  EXPECT_FALSE(IsMissed(Find(Seen(325, 6, other_))));
}

TEST_F(LandmarkSightsTest, WhereNothingIsSeenThePictureMayBeDark) {
  EXPECT_FALSE(IsMissed(Find(Seen(600, 12, other_))));
}

// Half of the differing bits of a descriptor that has nothing in common.
TEST_F(LandmarkSightsTest, WhatLooksALittleLikeItIsNoEvidence) {
  Descriptor like = descriptor_;
  like.words[0] ^= ~0ull;
  const LandmarkSights sights = Find(Seen(320, 10, like));
  EXPECT_EQ(sights.seen.size(), 1u);
  EXPECT_FALSE(IsMissed(sights));
}

TEST_F(LandmarkSightsTest, WhoIsNotClosedSaysNothing) {
  Add({{3}, 0}, Seen(322, 12, other_));
  view_.closed.erase({3});
  const LandmarkSights sights = Find(Seen(322, 10, descriptor_));
  EXPECT_FALSE(IsMissed(sights));
  EXPECT_EQ(sights.seen.size(), 2u);
}

}  // namespace
}  // namespace corbslam::map_store
