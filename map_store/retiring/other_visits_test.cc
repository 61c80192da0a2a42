#include "map_store/retiring/other_visits.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map_store/testing/drive_views.h"
#include "map_store/testing/shared_world.h"

namespace corbslam::map_store {
namespace {

using testing::Joined;
using testing::MakeDriveView;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::TheWorld;

SyntheticMap DriveFrom(uint64_t session, double begin_degrees) {
  testing::SyntheticMapOptions options;
  options.local_map = {session};
  options.seed = session;
  return MakeSyntheticMap(TheWorld().world, PosesOnRing(begin_degrees, 4, 6), options);
}

TEST(OtherVisitsTest, WhoLooksAtTheSamePlaceWithoutSharingALandmark) {
  const SyntheticMap first = DriveFrom(1, 1);
  const SyntheticMap second = DriveFrom(2, 1);
  const RetiringView view = MakeDriveView({&first, &second}, TheWorld().world, Joined::kNone);
  const OtherVisits other_visits = FindOtherVisits(view, {});
  for (uint32_t i = 0; i < 6; ++i) {
    const KeyframeId id{{1}, i};
    ASSERT_TRUE(other_visits.contains(id));
    const std::vector<KeyframeId>& others = other_visits.at(id);
    EXPECT_TRUE(std::ranges::find(others, KeyframeId{{2}, i}) != others.end());
    for (const KeyframeId& other : others) EXPECT_EQ(other.local_map, LocalMapId{2});
  }
}

TEST(OtherVisitsTest, NobodyWhoStandsElsewhere) {
  const SyntheticMap first = DriveFrom(1, 1);
  const SyntheticMap second = DriveFrom(2, 180);
  EXPECT_TRUE(FindOtherVisits(MakeDriveView({&first, &second}, TheWorld().world, Joined::kNone), {})
                  .empty());
}

TEST(OtherVisitsTest, NobodyWhoLooksElsewhere) {
  const SyntheticMap first = DriveFrom(1, 1);
  const SyntheticMap second = DriveFrom(2, 1);
  RetiringView view = MakeDriveView({&first, &second}, TheWorld().world, Joined::kNone);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()));
  for (uint32_t i = 0; i < 6; ++i) {
    const KeyframeId id{{2}, i};
    const Rigid3d& pose = view.map.FindKeyframe(id)->camera_from_map;
    view.map.SetPose(id, Rigid3d{turn, Eigen::Vector3d::Zero()} * pose);
  }
  EXPECT_TRUE(FindOtherVisits(view, {}).empty());
}

TEST(OtherVisitsTest, NobodyOfALocalMapThatIsOpen) {
  const SyntheticMap first = DriveFrom(1, 1);
  const SyntheticMap second = DriveFrom(2, 1);
  RetiringView view = MakeDriveView({&first, &second}, TheWorld().world, Joined::kNone);
  view.closed.erase(LocalMapId{2});
  for (const auto& [id, others] : FindOtherVisits(view, {})) EXPECT_EQ(id.local_map, LocalMapId{2});
}

}  // namespace
}  // namespace corbslam::map_store
