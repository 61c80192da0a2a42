#include "client_agent/far/far_maps.h"

#include <gtest/gtest.h>

#include <set>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"
#include "client_agent/far/testing/spooled_row.h"
#include "client_agent/map/map_bytes.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kPassed{31};
constexpr LocalMapId kPassedNext{32};
constexpr LocalMapId kInUse{33};
constexpr uint32_t kKeyframes = 100;

// What a picture looks like is said by the first word of its descriptors.
std::shared_ptr<const Words> LooksOf(const std::vector<Descriptor>& descriptors) {
  auto words = std::make_shared<Words>();
  const auto place = static_cast<uint32_t>(descriptors.front().words[0]);
  words->bag = {{0, 0.2F}, {2 * place + 1, 0.4F}, {2 * place + 2, 0.4F}};
  return words;
}

// Two local maps lie one behind the other along x; the robot is in a third.
class FarMapsTest : public ::testing::Test {
 protected:
  FarMapsTest() {
    far_.BeginLocalMap(kPassed, /*goes_on=*/false);
    far_.BeginLocalMap(kPassedNext, /*goes_on=*/true);
    Keep(kPassed, 0);
    far_.BeginLocalMap(kInUse, /*goes_on=*/true);
    Keep(kPassedNext, kKeyframes);
  }

  static FarMapsOptions Options() {
    FarMapsOptions options;
    options.max_bytes = 1 << 20;
    options.max_bag_bytes = 4 << 20;
    options.radius = 10;
    return options;
  }

  static Map MapOf(LocalMapId local_map, uint32_t begin_m) {
    Map map;
    SpooledRow(local_map, kKeyframes, begin_m).Fill(&LooksOf, map);
    return map;
  }
  void Keep(LocalMapId local_map, uint32_t begin_m) {
    far_.Keep(local_map, MapOf(local_map, begin_m));
  }

  // The frame looks like the keyframe there.
  void At(double x, std::optional<uint32_t> looks_like = {}) {
    FarFrame frame;
    frame.timestamp_ns = (time_ns_ += 1'000'000'000);
    frame.centre = Eigen::Vector3d(x, 0, 0);
    if (looks_like.has_value()) {
      frame.payload = SpooledRow({99}, 1, *looks_like).keyframes().begin()->second.payload;
    }
    far_.Note(frame);
    far_.Step();
  }
  void Take(LocalMapId for_local_map, const SharedUpdate& update) {
    EXPECT_EQ(for_local_map, wanted_for_);
    most_ = std::max(most_, update.keyframes.size());
    for (const SharedKeyframe& keyframe : update.keyframes) held_.insert(keyframe.payload->id);
    for (const KeyframeId id : update.removed_keyframes) held_.erase(id);
  }
  absl::StatusOr<SpooledMap> Read(LocalMapId local_map) {
    ++reads_;
    if (damaged_) return absl::DataLossError("file 000007.spool: record at byte 4711");
    return SpooledRow(local_map, kKeyframes, local_map == kPassed ? 0 : kKeyframes);
  }

  LocalMapId wanted_for_ = kInUse;
  bool damaged_ = false;
  int reads_ = 0;
  size_t most_ = 0;
  std::set<KeyframeId> held_;
  int64_t time_ns_ = 0;
  FarMaps far_{
      Options(), [this](LocalMapId local_map) { return Read(local_map); },
      [this](LocalMapId local_map, const SharedUpdate& update) { Take(local_map, update); },
      &LooksOf};
};

TEST_F(FarMapsTest, WhereTheRobotComesNearItsPartsComeBack) {
  At(500);
  EXPECT_EQ(reads_, 0);
  EXPECT_TRUE(held_.empty());
  At(50);
  EXPECT_EQ(held_.size(), 21u);
  EXPECT_TRUE(held_.contains({kPassed, 50}));
  EXPECT_EQ(reads_, 1);
  EXPECT_LE(most_, 4u) << "tracking waits while a map is written";
  // Over the seam.
  At(100);
  EXPECT_TRUE(held_.contains({kPassed, 95}));
  EXPECT_TRUE(held_.contains({kPassedNext, 5}));
  EXPECT_FALSE(held_.contains({kPassed, 50}));
  At(500);
  EXPECT_TRUE(held_.empty());
  EXPECT_EQ(far_.status().local_maps, 2u);
  EXPECT_EQ(far_.status().keyframes, 2 * kKeyframes);
}

TEST_F(FarMapsTest, WhatComesBackIsBounded) {
  FarMapsOptions options = Options();
  const Map map = MapOf(kPassed, 0);
  options.max_bytes = 6 * (EstimateBytes(map) / map.keyframes().size());
  FarMaps far(
      options, [this](LocalMapId local_map) { return Read(local_map); },
      [this](LocalMapId local_map, const SharedUpdate& update) { Take(local_map, update); },
      &LooksOf);
  far.BeginLocalMap(kPassed, false);
  far.BeginLocalMap(kInUse, true);
  far.Keep(kPassed, map);
  FarFrame frame;
  frame.centre = Eigen::Vector3d(50, 0, 0);
  far.Note(frame);
  far.Step();
  EXPECT_EQ(held_.size(), 6u);
}

TEST_F(FarMapsTest, APlaceThatIsRecognisedComesBackThoughTheRobotBelievesToBeElsewhere) {
  At(500, 60);
  At(500, 60);
  EXPECT_TRUE(held_.contains({kPassed, 60}));
  EXPECT_EQ(far_.status().recognised, 1u);
  At(501, 60);
  EXPECT_EQ(far_.status().recognised, 1u) << "it is on its way";
  EXPECT_EQ(reads_, 1);
}

TEST_F(FarMapsTest, ALocalMapThatCannotBeReadIsSaidOnceAndTheRobotGoesOn) {
  damaged_ = true;
  At(50);
  EXPECT_TRUE(held_.empty());
  EXPECT_EQ(far_.status().unreadable, 1u);
  damaged_ = false;
  At(51);
  At(60);
  EXPECT_EQ(reads_, 1) << "nobody tries again";
  At(150);
  EXPECT_TRUE(held_.contains({kPassedNext, 50}));
}

TEST_F(FarMapsTest, TheNextLocalMapIsToldAnew) {
  At(50);
  const size_t held = held_.size();
  held_.clear();
  wanted_for_ = {34};
  far_.BeginLocalMap({34}, /*goes_on=*/true);
  At(50);
  EXPECT_EQ(held_.size(), held);
}

TEST_F(FarMapsTest, InAnotherFrameNobodyKnowsWhereTheyLie) {
  wanted_for_ = {34};
  far_.BeginLocalMap({34}, /*goes_on=*/false);
  Keep(kInUse, 0);
  At(50);
  EXPECT_EQ(reads_, 0);
  EXPECT_EQ(far_.status().local_maps, 0u);
}

TEST_F(FarMapsTest, TheThreadDoesTheSame) {
  absl::Notification came;
  FarMaps far(
      Options(), [this](LocalMapId local_map) { return Read(local_map); },
      [&](LocalMapId, const SharedUpdate& update) {
        if (!update.keyframes.empty() && !came.HasBeenNotified()) came.Notify();
      },
      &LooksOf);
  far.BeginLocalMap(kPassed, false);
  far.BeginLocalMap(kInUse, true);
  far.Keep(kPassed, MapOf(kPassed, 0));
  far.Start();
  FarFrame frame;
  frame.centre = Eigen::Vector3d(50, 0, 0);
  far.Note(frame);
  came.WaitForNotification();
  far.Stop();
}

}  // namespace
}  // namespace corbslam::client_agent
