#include "map_store/retiring/keyframe_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "map_store/testing/drive_views.h"
#include "map_store/testing/shared_world.h"

namespace corbslam::map_store {
namespace {

using testing::Joined;
using testing::MakeDriveView;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::TheWorld;

constexpr int kKeyframes = 14;

SyntheticMap Drive(uint64_t session, double begin_degrees) {
  testing::SyntheticMapOptions options;
  options.local_map = {session};
  options.seed = session;
  options.drift_yaw_rad = 0.002;
  return MakeSyntheticMap(TheWorld().world, PosesOnRing(begin_degrees, 4, kKeyframes), options);
}

// Three sessions over one part of the ring.
class KeyframeChoiceTest : public ::testing::Test {
 protected:
  RetiringView View(Joined joined) {
    return MakeDriveView({&first_, &second_, &third_}, TheWorld().world, joined);
  }
  static std::vector<RetiredKeyframe> Choose(const RetiringView& view,
                                             const ChoiceOptions& options = {}) {
    return ChooseKeyframes(view, FindSights(view, {}), {}, options);
  }
  static std::map<LocalMapId, int> CountByLocalMap(const std::vector<RetiredKeyframe>& retired) {
    std::map<LocalMapId, int> counts;
    for (const RetiredKeyframe& one : retired) ++counts[one.id.local_map];
    return counts;
  }

  SyntheticMap first_ = Drive(1, 1);
  SyntheticMap second_ = Drive(2, 2);
  SyntheticMap third_ = Drive(3, 3);
};

TEST_F(KeyframeChoiceTest, EarlierSessionsGoFirstAndRootsStay) {
  const std::vector<RetiredKeyframe> retired = Choose(View(Joined::kMerged));
  std::map<LocalMapId, int> counts = CountByLocalMap(retired);
  EXPECT_GE(counts[LocalMapId{1}], kKeyframes / 2);
  EXPECT_GE(counts[LocalMapId{1}], counts[LocalMapId{2}]);
  EXPECT_EQ(counts[LocalMapId{3}], 0) << "what the last one has of the place stays";
  for (const RetiredKeyframe& one : retired) EXPECT_NE(one.id.index, 0u);
}

// What is left of a session that has become a part is as any other keyframe: of a place that is
// visited for years not even a keyframe a visit stays.
TEST_F(KeyframeChoiceTest, APartsFirstKeyframeGoesToo) {
  RetiringView view = View(Joined::kMerged);
  view.closed.at(LocalMapId{2}).whole = LocalMapId{1};
  ChoiceOptions all;
  all.seen_share = 0;
  all.max_homeless_share = 1;
  const std::vector<RetiredKeyframe> retired = Choose(view, all);
  std::set<KeyframeId> going;
  for (const RetiredKeyframe& one : retired) going.insert(one.id);
  EXPECT_TRUE(going.contains(KeyframeId{{2}, 0}));
  EXPECT_FALSE(going.contains(KeyframeId{{1}, 0})) << "the whole's own stays";
  for (const RetiredKeyframe& one : retired) {
    EXPECT_FALSE(going.contains(one.parent)) << ToString(one.id);
    EXPECT_EQ(view.closed.at(one.parent.local_map).whole, LocalMapId{1}) << ToString(one.id);
    const Rigid3d local = one.parent_from_removed * view.local_poses.at(one.id);
    EXPECT_LT((local.translation - view.local_poses.at(one.parent).translation).norm(), 1e-9);
  }
}

TEST_F(KeyframeChoiceTest, ThePartsLastKeyframeHoldsNothingTogether) {
  RetiringView view = View(Joined::kMerged);
  view.closed.at(LocalMapId{2}).whole = LocalMapId{1};
  view.overlaps = {{{{2}, 5}, {{3}, 7}}, {{{1}, 5}, {{3}, 7}}};
  ChoiceOptions all;
  all.seen_share = 0;
  all.max_homeless_share = 1;
  const auto has = [](const std::vector<RetiredKeyframe>& retired, KeyframeId id) {
    return std::ranges::any_of(retired, [id](const auto& one) { return one.id == id; });
  };
  const std::vector<RetiredKeyframe> retired = Choose(view, all);
  EXPECT_TRUE(has(retired, {{2}, 5}));
  EXPECT_FALSE(has(retired, {{1}, 5})) << "the whole's holds it to the newest";
  // One that the view does not have is left of the part, and held by nothing else.
  ++view.closed.at(LocalMapId{2}).keyframes;
  EXPECT_FALSE(has(Choose(view, all), {{2}, 5}));
}

TEST_F(KeyframeChoiceTest, APartsFirstKeyframeStaysWithoutANeighbourOfTheWhole) {
  const SyntheticMap elsewhere = Drive(4, 120);
  RetiringView view =
      MakeDriveView({&elsewhere, &second_, &third_}, TheWorld().world, Joined::kMerged);
  view.closed.at(LocalMapId{2}).whole = LocalMapId{4};
  ChoiceOptions all;
  all.seen_share = 0;
  all.max_homeless_share = 1;
  size_t left = kKeyframes;
  for (const RetiredKeyframe& one : Choose(view, all)) left -= one.id.local_map == LocalMapId{2};
  EXPECT_GE(left, 1u) << "nothing is left that poses could be relative to";
}

TEST_F(KeyframeChoiceTest, WhatStaysStandsInAtTheRightPlace) {
  const RetiringView view = View(Joined::kMerged);
  const std::vector<RetiredKeyframe> retired = Choose(view);
  ASSERT_FALSE(retired.empty());
  std::set<KeyframeId> going;
  for (const RetiredKeyframe& one : retired) going.insert(one.id);
  for (const RetiredKeyframe& one : retired) {
    EXPECT_FALSE(going.contains(one.parent));
    EXPECT_FALSE(going.contains(one.stand_in.keyframe));
    EXPECT_EQ(one.parent.local_map, one.id.local_map);
    const Rigid3d pose =
        one.stand_in.keyframe_from_retired * view.map.FindKeyframe(one.id)->camera_from_map;
    const Rigid3d& stand_in = view.map.FindKeyframe(one.stand_in.keyframe)->camera_from_map;
    EXPECT_LT((pose.translation - stand_in.translation).norm(), 1e-9);
    const Rigid3d local = one.parent_from_removed * view.local_poses.at(one.id);
    EXPECT_LT((local.translation - view.local_poses.at(one.parent).translation).norm(), 1e-9);
  }
}

// Nearly everything that they saw is still seen by several others.
TEST_F(KeyframeChoiceTest, WhatIsSeenStaysSeen) {
  const RetiringView view = View(Joined::kMerged);
  std::set<KeyframeId> going;
  for (const RetiredKeyframe& one : Choose(view)) going.insert(one.id);
  int landmarks = 0;
  int lost = 0;
  for (const auto& [id, point] : view.map.points()) {
    ++landmarks;
    int left = 0;
    for (const auto& [keyframe, keypoint] : point.observations) left += !going.contains(keyframe);
    lost += left == 0;
  }
  EXPECT_LT(lost, landmarks / 8);
}

// Fusion may have joined nothing: then what looks the same in the same places counts.
TEST_F(KeyframeChoiceTest, LooksCountWherePointsAreNotJoined) {
  const auto retired = CountByLocalMap(Choose(View(Joined::kNone)));
  ASSERT_TRUE(retired.contains(LocalMapId{1}));
  EXPECT_GE(retired.at(LocalMapId{1}), kKeyframes / 2);
}

// Points of which later sessions have none of their own keep a keyframe of the one that has.
TEST_F(KeyframeChoiceTest, PointsKeepAHome) {
  const RetiringView view = View(Joined::kShared);
  const std::vector<RetiredKeyframe> retired = Choose(view);
  ASSERT_FALSE(retired.empty());
  std::set<KeyframeId> going;
  for (const RetiredKeyframe& one : retired) going.insert(one.id);
  int homeless = 0;
  for (const auto& [id, members] : view.landmarks) {
    bool seen = false;
    bool at_home = false;
    for (const auto& [keyframe, keypoint] : view.map.FindPoint(id)->observations) {
      if (going.contains(keyframe)) continue;
      seen = true;
      at_home = at_home || keyframe.local_map == id.local_map;
    }
    homeless += seen && !at_home;
  }
  EXPECT_LT(homeless, static_cast<int>(view.landmarks.size()) / 20);
}

TEST_F(KeyframeChoiceTest, TheLastOverlapStays) {
  RetiringView view = View(Joined::kMerged);
  const std::vector<RetiredKeyframe> free = Choose(view);
  ASSERT_GE(free.size(), 2u);
  const KeyframeId held = free[0].id;
  view.overlaps = {{held, {{3}, 7}}};
  for (const RetiredKeyframe& one : Choose(view)) EXPECT_NE(one.id, held);
}

TEST_F(KeyframeChoiceTest, OverlapsThatOthersReplaceGoLast) {
  RetiringView view = View(Joined::kMerged);
  const KeyframeId first{{1}, 5};
  view.overlaps = {{first, {{3}, 7}}, {{{1}, 0}, {{3}, 0}}};
  const std::vector<RetiredKeyframe> retired = Choose(view);
  bool has_gone = false;
  for (const RetiredKeyframe& one : retired) {
    EXPECT_FALSE(has_gone) << ToString(one.id);
    has_gone = has_gone || one.id == first;
  }
}

TEST_F(KeyframeChoiceTest, AViewFromAloneStays) {
  const SyntheticMap elsewhere = Drive(4, 120);
  const RetiringView view = MakeDriveView({&first_, &elsewhere}, TheWorld().world, Joined::kMerged);
  ChoiceOptions all;
  all.min_others = kKeyframes;  // More than one session has of anything.
  EXPECT_TRUE(Choose(view, all).empty());
}

// Five sessions over one place that look different to each other: no rule of what is seen lets go.
class VisitsOfAPlaceTest : public KeyframeChoiceTest {
 protected:
  VisitsOfAPlaceTest() { options_.seen_share = 2; }
  // Local maps of which keyframes that stay look at the keyframe's place.
  static size_t CountVisits(const OtherVisits& other_visits, KeyframeId id,
                            const std::set<KeyframeId>& going) {
    std::set<LocalMapId> visits;
    const auto it = other_visits.find(id);
    if (it == other_visits.end()) return 0;
    for (const KeyframeId& other : it->second) {
      if (!going.contains(other)) visits.insert(other.local_map);
    }
    return visits.size();
  }

  SyntheticMap fourth_ = Drive(4, 4);
  SyntheticMap fifth_ = Drive(5, 5);
  RetiringView view_ = MakeDriveView({&first_, &second_, &third_, &fourth_, &fifth_},
                                     TheWorld().world, Joined::kMerged);
  ChoiceOptions options_;
};

TEST_F(VisitsOfAPlaceTest, AreBounded) {
  const std::vector<RetiredKeyframe> retired = Choose(view_, options_);
  const auto counts = CountByLocalMap(retired);
  ASSERT_FALSE(retired.empty());
  EXPECT_FALSE(counts.contains(LocalMapId{5})) << "the newest visit stays";
  std::set<KeyframeId> going;
  for (const RetiredKeyframe& one : retired) going.insert(one.id);
  const OtherVisits other_visits = FindOtherVisits(view_, {});
  for (const KeyframeId& id : view_.candidates) {
    if (going.contains(id) || id.index == 0 || id.local_map == LocalMapId{5}) continue;
    EXPECT_LT(CountVisits(other_visits, id, going), options_.max_visits) << ToString(id);
  }
  for (const RetiredKeyframe& one : retired) {
    EXPECT_GE(CountVisits(other_visits, one.id, going), options_.max_visits - 1)
        << ToString(one.id);
  }
}

TEST_F(VisitsOfAPlaceTest, StayWhileThereIsRoom) {
  options_.max_visits = 5;
  EXPECT_TRUE(Choose(view_, options_).empty());
}

TEST_F(VisitsOfAPlaceTest, ThatOthersDependOnStay) {
  options_.max_homeless_share_where_visited = -1;
  EXPECT_TRUE(Choose(view_, options_).empty());
}

TEST_F(VisitsOfAPlaceTest, EveryCandidateThatStaysHasAReason) {
  StayCounts stays;
  const auto retired = ChooseKeyframes(view_, FindSights(view_, {}), {}, options_, &stays);
  EXPECT_EQ(stays.roots, 5u);
  EXPECT_GE(stays.newest, static_cast<size_t>(kKeyframes - 1));
  EXPECT_EQ(stays.roots + stays.newest + stays.links + stays.homeless + stays.unseen +
                stays.unplaced + retired.size(),
            view_.candidates.size());
}

// Of units that differ nothing stands in for anything.
TEST_F(KeyframeChoiceTest, StandInsHaveTheSameUnits) {
  RetiringView view = View(Joined::kMerged);
  for (auto& [id, pose] : view.poses) {
    if (id.local_map == LocalMapId{1}) pose = Similarity3d{2, pose.rotation, 2 * pose.translation};
  }
  for (const RetiredKeyframe& one : Choose(view)) {
    EXPECT_EQ(one.id.local_map == LocalMapId{1}, one.stand_in.keyframe.local_map == LocalMapId{1});
  }
}

}  // namespace
}  // namespace corbslam::map_store
