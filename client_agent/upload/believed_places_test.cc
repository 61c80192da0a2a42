#include "client_agent/upload/believed_places.h"

#include <gtest/gtest.h>

#include <memory>

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kMap{1};
constexpr KeyframeId kReference{kMap, 0};
constexpr KeyframeId kOther{kMap, 1};
constexpr MapPointId kPoint{kMap, 7};

Rigid3d Turned(double angle_rad, double x_m) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY())),
          {x_m, 0, 0.5}};
}

class BelievedPlacesTest : public ::testing::Test {
 protected:
  BelievedPlacesTest() {
    places_.PlaceKeyframe(kReference, Turned(0.2, 1));
    places_.PlaceKeyframe(kOther, Turned(0.1, 2));
    places_.AddPoint(kPoint, position_, kReference);
  }
  double DistanceTo(const Eigen::Vector3d& position) const {
    return (*places_.Position(kPoint) - position).norm();
  }

  const Eigen::Vector3d position_{1, 2, 8};
  BelievedPlaces places_;
};

TEST_F(BelievedPlacesTest, APointIsWhereItWasToldUntilItsReferenceMoves) {
  EXPECT_LT(DistanceTo(position_), 1e-12);
  places_.PlaceKeyframe(kOther, Turned(1, 1));
  EXPECT_LT(DistanceTo(position_), 1e-12);
  places_.PlaceKeyframe(kReference, Turned(1, 1));
  EXPECT_LT(DistanceTo(Turned(1, 1).Inverse() * (Turned(0.2, 1) * position_)), 1e-12);
  places_.MovePoint(kPoint, {0, 0, 3});
  EXPECT_LT(DistanceTo({0, 0, 3}), 1e-12);
}

TEST_F(BelievedPlacesTest, WhereTheStoreMovesNoPointsTheyStay) {
  places_.PlaceKeyframe(kReference, Turned(1, 1), /*points_follow=*/false);
  EXPECT_LT(DistanceTo(position_), 1e-12);
  // The points move again at a store that moves them.
  places_.PlaceKeyframe(kReference, Turned(0.4, 3));
  EXPECT_LT(DistanceTo(Turned(0.4, 3).Inverse() * (Turned(1, 1) * position_)), 1e-12);
}

TEST_F(BelievedPlacesTest, ForgottenPlacesAreUnknownUntilToldAgain) {
  places_.ForgetPlaces();
  EXPECT_FALSE(places_.Position(kPoint).has_value());
  places_.PlaceKeyframe(kReference, Turned(1, 1), /*points_follow=*/false);
  EXPECT_FALSE(places_.Position(kPoint).has_value());
  places_.MovePoint(kPoint, position_);
  EXPECT_LT(DistanceTo(position_), 1e-12);
}

TEST_F(BelievedPlacesTest, APointWhoseReferenceIsGoneStays) {
  places_.RemoveKeyframe(kReference);
  EXPECT_TRUE(places_.Followers(kReference).empty());
  EXPECT_LT(DistanceTo(position_), 1e-12);
  places_.MovePoint(kPoint, {0, 0, 3});
  EXPECT_LT(DistanceTo({0, 0, 3}), 1e-12);
}

TEST_F(BelievedPlacesTest, WhatIsGoneFollowsNobody) {
  constexpr MapPointId kSecond{kMap, 8};
  places_.AddPoint(kSecond, position_, kReference);
  EXPECT_EQ(places_.Followers(kReference).size(), 2u);
  places_.RemovePoint(kPoint);
  EXPECT_EQ(places_.Followers(kReference), std::vector<MapPointId>{kSecond});
  EXPECT_FALSE(places_.Position(kPoint).has_value());
  EXPECT_TRUE(places_.Followers(kOther).empty());
  places_.MovePoint(kPoint, position_);  // Nothing happens.
}

// A stereo camera of 500 px and 0.1 m is 10 m before the point: a centimetre across is half a
// pixel, a metre of depth nearly half a pixel of disparity.
class LooksTheSameTest : public ::testing::Test {
 protected:
  explicit LooksTheSameTest(double baseline_m = 0.1) {
    Keyframe keyframe;
    Features features;
    features.keypoints.resize(1);
    keyframe.payload = MakeKeyframePayload(
        kReference, 0, 0,
        std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, baseline_m, 4}),
        features);
    map_.AddKeyframe(keyframe);
    MapPoint point;
    point.id = kPoint;
    point.position_in_map = {0, 0, 10};
    map_.AddPoint(point);
    map_.AddObservation(kPoint, kReference, 0);
  }
  bool Same(const Eigen::Vector3d& told) const {
    return LooksTheSame(map_, *map_.FindPoint(kPoint), told, 0.5);
  }

  Map map_;
};

TEST_F(LooksTheSameTest, WithinHalfAPixel) {
  EXPECT_TRUE(Same({0, 0, 10}));
  EXPECT_TRUE(Same({0.0099, 0, 10}));
  EXPECT_FALSE(Same({0.0101, 0, 10}));
  EXPECT_FALSE(Same({0, -0.0101, 10}));
}

TEST_F(LooksTheSameTest, InDisparityToo) {
  EXPECT_TRUE(Same({0, 0, 10.9}));
  EXPECT_FALSE(Same({0, 0, 11.2}));
}

TEST_F(LooksTheSameTest, NeverFromBehind) { EXPECT_FALSE(Same({0, 0, -10})); }

TEST_F(LooksTheSameTest, ToNobody) {
  map_.RemoveObservation(kPoint, kReference);
  EXPECT_TRUE(Same({5, 5, 5}));
}

class LooksTheSameToOneEyeTest : public LooksTheSameTest {
 protected:
  LooksTheSameToOneEyeTest() : LooksTheSameTest(0) {}
};

TEST_F(LooksTheSameToOneEyeTest, WhateverTheDepth) { EXPECT_TRUE(Same({0, 0, 20})); }

}  // namespace
}  // namespace corbslam::client_agent
