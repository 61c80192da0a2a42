#include "map_store/retiring/fading.h"

#include <gtest/gtest.h>

#include <set>

#include "map_store/testing/session_views.h"
#include "map_store/testing/shared_world.h"

namespace corbslam::map_store {
namespace {

using testing::Joined;
using testing::MakeSessionView;
using testing::MakeSyntheticMap;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::SyntheticWorld;
using testing::TheWorld;

// Drives 14 keyframes over one part of the ring, a little aside of the other sessions'.
SyntheticMap Drive(uint64_t session, const SyntheticWorld& world) {
  testing::SyntheticMapOptions options;
  options.local_map = {session};
  options.seed = session;
  return MakeSyntheticMap(world, PosesOnRing(static_cast<double>(session), 4, 14), options);
}

std::vector<size_t> EverySeventh() {
  std::vector<size_t> things;
  for (size_t i = 0; i < TheWorld().world.positions_m.size(); i += 7) things.push_back(i);
  return things;
}

std::vector<MapPointId> Fade(const RetiringView& view) {
  return FindFaded(view, FindSights(view, {}), {});
}

// A first session, and two later ones in the same world or another one.
class FadingTest : public ::testing::Test {
 protected:
  RetiringView View(const SyntheticWorld& second, const SyntheticWorld& third, Joined joined) {
    second_ = Drive(2, second);
    third_ = Drive(3, third);
    return MakeSessionView({&first_, &second_, &third_}, TheWorld().world, joined);
  }

  const SyntheticWorld& world_ = TheWorld().world;
  const SyntheticWorld changed_ = testing::Without(world_, EverySeventh());
  SyntheticMap first_ = Drive(1, world_);
  SyntheticMap second_;
  SyntheticMap third_;
};

TEST_F(FadingTest, WhatStaysNeverFades) {
  for (const Joined joined : {Joined::kNone, Joined::kMerged, Joined::kShared}) {
    const std::vector<MapPointId> faded = Fade(View(world_, world_, joined));
    EXPECT_EQ(faded.size(), 0u) << static_cast<int>(joined);
  }
}

TEST_F(FadingTest, WhatVanishedFades) {
  const std::vector<size_t> gone = EverySeventh();
  const std::set<size_t> vanished(gone.begin(), gone.end());
  size_t there = 0;
  for (const auto& [id, thing] : first_.world_point) {
    there += vanished.contains(thing) && first_.map.FindPoint(id)->observations.size() >= 6;
  }
  const std::vector<MapPointId> faded = Fade(View(changed_, changed_, Joined::kMerged));
  for (const MapPointId& id : faded) {
    EXPECT_EQ(id.local_map, LocalMapId{1});
    EXPECT_TRUE(vanished.contains(first_.world_point.at(id))) << ToString(id);
  }
  EXPECT_GT(faded.size(), there / 2) << "of " << there;
}

TEST_F(FadingTest, OneSessionIsNoEvidence) {
  EXPECT_EQ(Fade(View(world_, changed_, Joined::kMerged)).size(), 0u)
      << "the second session still saw it";
  second_ = Drive(2, changed_);
  EXPECT_EQ(Fade(MakeSessionView({&first_, &second_}, TheWorld().world, Joined::kMerged)).size(),
            0u);
}

// At night nothing looks as it did.
TEST_F(FadingTest, SessionsToWhichAllLooksDifferentSayNothing) {
  SyntheticWorld night = world_;
  for (Descriptor& descriptor : night.descriptors) {
    for (uint64_t& word : descriptor.words) word = ~word;
  }
  EXPECT_EQ(Fade(View(night, night, Joined::kNone)).size(), 0u);
}

TEST_F(FadingTest, WhatALiveRobotSeesStays) {
  RetiringView view = View(changed_, changed_, Joined::kMerged);
  const size_t faded = Fade(view).size();
  ASSERT_GT(faded, 0u);
  // The first session's robot goes on.
  view.closed.erase({1});
  EXPECT_EQ(Fade(view).size(), 0u);
}

TEST_F(FadingTest, AMemberOfALiveRobotsMapKeepsItsLandmark) {
  RetiringView view = View(changed_, changed_, Joined::kMerged);
  const std::vector<MapPointId> before = Fade(view);
  ASSERT_FALSE(before.empty());
  view.landmarks[before.front()].push_back({{9}, 1});
  EXPECT_EQ(Fade(view).size(), before.size() - 1);
}

}  // namespace
}  // namespace corbslam::map_store
