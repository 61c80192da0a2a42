#include "client_agent/shared/own_places.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

constexpr KeyframeId kKeyframe{LocalMapId{1}, 3};

Rigid3d CameraAt(double x) { return {Eigen::Quaterniond::Identity(), {-x, 0, 0}}; }

double XOf(const OwnPlaces& places) {
  return CameraCentre(places.places().at(kKeyframe).camera_from_local).x();
}

// Moves the keyframe from x = 0 to so many metres, in steps of one.
void GoTo(int x, OwnPlaces& places) {
  for (int i = 0; i < x; ++i) {
    OwnCorrection correction;
    correction.motions[kKeyframe] = {CameraAt(i), CameraAt(i + 1)};
    places.Correct(correction);
  }
}

TEST(OwnPlacesTest, WhatTheStoreDoesNotKnowYetIsAdded) {
  OwnPlaces places;
  GoTo(3, places);
  places.Tell({kKeyframe, Similarity3d(), CameraAt(1)});
  EXPECT_NEAR(XOf(places), 3, 1e-9);
  places.Tell({kKeyframe, Similarity3d(), CameraAt(3)});
  EXPECT_NEAR(XOf(places), 3, 1e-9);
}

TEST(OwnPlacesTest, AnythingThatTheStoreWasNotToldForLongIsAdded) {
  OwnPlaces places;
  GoTo(50, places);
  places.Tell({kKeyframe, Similarity3d(), CameraAt(0)});
  EXPECT_NEAR(XOf(places), 50, 1e-9);
}

TEST(OwnPlacesTest, AMapWithoutMetresLiesInTheGlobalFrameByASimilarity) {
  const Similarity3d global_from_local = {
      2.5,
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())),
      {3, -4, 5}};
  const Rigid3d camera_from_local = CameraAt(2);
  OwnPlaces places;
  places.Tell({kKeyframe, Similarity3d::FromRigid(camera_from_local) * global_from_local.Inverse(),
               camera_from_local});
  const Similarity3d found = places.places().at(kKeyframe).GlobalFromLocal();
  EXPECT_NEAR(found.scale, 2.5, 1e-12);
  EXPECT_LT(found.rotation.angularDistance(global_from_local.rotation), 1e-9);
  EXPECT_LT((found.translation - global_from_local.translation).norm(), 1e-9);
}

}  // namespace
}  // namespace corbslam::client_agent
