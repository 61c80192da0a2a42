#include "client_agent/loop_closing/loop_closer.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/fusing/testing/fused_maps.h"
#include "slam/matching/word_matching.h"
#include "slam/rendering/map_picture.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::client_agent {
namespace {

using testing::AteRmse_m;
using testing::MakeRingWorld;
using testing::MakeSyntheticMap;
using testing::PosesOf;
using testing::PosesOnRing;
using testing::SyntheticMap;

constexpr LocalMapId kOwn{0xa};
constexpr LocalMapId kOther{0xb};

void AddAll(const Map& from, Map& to) {
  for (const auto& [id, original] : from.keyframes()) {
    Keyframe keyframe;
    keyframe.payload = original.payload;
    keyframe.words = original.words;
    keyframe.camera_from_map = original.camera_from_map;
    to.AddKeyframe(std::move(keyframe));
  }
  for (const auto& [id, keyframe] : from.keyframes()) to.SetParent(id, keyframe.parent);
  for (const auto& [id, point] : from.points()) {
    to.AddPoint(point);
    for (const auto& [keyframe, keypoint] : point.observations) {
      to.AddObservation(id, keyframe, keypoint);
    }
  }
}

// Moves a map as a whole into another frame.
Map Moved(const Map& map, const Rigid3d& target_from_map) {
  Map moved = map;
  for (const auto& [id, keyframe] : map.keyframes()) {
    moved.SetPose(id, keyframe.camera_from_map * target_from_map.Inverse());
  }
  for (const auto& [id, point] : map.points()) {
    moved.SetPosition(id, target_from_map * point.position_in_map);
  }
  for (const auto& [id, point] : map.points()) moved.UpdatePointGeometry(id);
  return moved;
}

MapPicture::Robot DrawRobot(const Map& map, LocalMapId local_map, const std::string& name) {
  MapPicture::Robot robot;
  robot.name = name;
  robot.is_own = local_map == kOwn;
  std::map<KeyframeId, size_t> drawn;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map != local_map) continue;
    drawn[id] = robot.keyframes.size();
    robot.keyframes.push_back(keyframe.camera_from_map.Inverse());
  }
  for (const auto& [id, entry] : drawn) {
    const auto parent = drawn.find(map.FindKeyframe(id)->parent);
    if (parent != drawn.end()) robot.edges.push_back({parent->second, entry});
  }
  return robot;
}

// Draws the own robot's map, what it holds of the other, and where the own one truly was.
cv::Mat Draw(const Map& map, const SyntheticMap& own, const std::string& title) {
  MapPicture picture;
  picture.title = title;
  picture.robots = {DrawRobot(map, kOwn, "bravo"), DrawRobot(map, kOther, "alpha, shared")};
  for (const auto& [id, point] : map.points()) picture.points.push_back(point.position_in_map);
  const Rigid3d map_from_world = own.true_camera_from_world.at({kOwn, 0});
  for (auto& path = picture.truth.emplace_back();
       const auto& [id, camera_from_world] : own.true_camera_from_world) {
    path.push_back((map_from_world * camera_from_world.Inverse()).translation);
  }
  const auto image = RenderMap(picture, {.width_px = 800});
  EXPECT_TRUE(image.ok()) << image.status();
  return image.ok() ? *image : cv::Mat(1, 800, CV_8UC3);
}

// Saves a picture for people, where CORBSLAM_PICTURE_DIR names a folder.
void SavePicture(const Map& before, const Map& after, const SyntheticMap& own) {
  const char* folder = std::getenv("CORBSLAM_PICTURE_DIR");
  if (folder == nullptr) return;
  cv::Mat both;
  cv::vconcat(Draw(before, own, "Before: bravo has drifted away from its truth"),
              Draw(after, own, "After: a loop closed against alpha's keyframes"), both);
  const absl::Status written = WriteImage(both, std::string(folder) + "/shared_loop.png");
  EXPECT_TRUE(written.ok()) << written;
}

// It stands in for the keyframe database: the keyframe that shares the most matches is the
// candidate.
class LoopCloserTest : public ::testing::Test {
 protected:
  LoopCloserTest()
      : world_(MakeRingWorld(3)),
        once_round_(MakeSyntheticMap(world_, PosesOnRing(0, 4.1, 88),
                                     {.local_map = kOwn, .seed = 5, .drift_yaw_rad = 0.0015})),
        drifting_(testing::SplitPoints(once_round_.map, 44)) {}

  std::unique_ptr<LoopCloser> MakeCloser() {
    return std::make_unique<LoopCloser>(
        LoopCloserOptions(), &map_, &queue_,
        [this](const Keyframe& query, const absl::btree_set<KeyframeId>& excluded) {
          return FindCandidates(query, excluded);
        },
        [this](const OwnCorrection& correction, GuardedMap&) {
          corrections_.push_back(correction);
        });
  }

  std::vector<KeyframeId> FindCandidates(const Keyframe& query,
                                         const absl::btree_set<KeyframeId>& excluded) const {
    return map_.Read([&](const Map& map) {
      KeyframeId best;
      size_t most = 30;
      for (const auto& [id, keyframe] : map.keyframes()) {
        if (excluded.contains(id)) continue;
        const size_t matches = MatchByWords(query, keyframe).size();
        if (matches <= most) continue;
        most = matches;
        best = id;
      }
      return best.IsValid() ? std::vector<KeyframeId>{best} : std::vector<KeyframeId>();
    });
  }

  void RunJobs() {
    while (const auto job = queue_.TryPopJob()) {
      (*job)(map_);
      queue_.Done();
    }
  }
  // A deterministic agent steps in this way, too.
  void StepUntilIdle(LoopCloser& closer) {
    while (closer.StepDetection() || closer.StepAdjustment()) RunJobs();
  }
  void Load(const Map& map) {
    map_.Write([&](Map& inner) { AddAll(map, inner); });
  }
  Map Copy() const {
    return map_.Read([](const Map& map) { return map; });
  }

  const testing::SyntheticWorld world_;
  const SyntheticMap once_round_;
  const Map drifting_;
  GuardedMap map_{kOwn};
  MappingQueue queue_;
  std::vector<OwnCorrection> corrections_;
};

TEST_F(LoopCloserTest, ClosingTheCircleLowersTheError) {
  Load(drifting_);
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 87});
  const double before_m = AteRmse_m(PosesOf(Copy()), once_round_.true_camera_from_world);
  StepUntilIdle(*closer);
  const double after_m = AteRmse_m(PosesOf(Copy()), once_round_.true_camera_from_world);
  EXPECT_EQ(closer->counts().closed, 1);
  EXPECT_EQ(closer->counts().closed_against_others, 0);
  EXPECT_EQ(closer->counts().adjusted, 1);
  EXPECT_GT(before_m, 0.3);
  EXPECT_LT(after_m, 0.3 * before_m);
  EXPECT_EQ(map_.corrections(), 2u);
  EXPECT_TRUE(closer->IsIdle());
  const Map closed = Copy();
  EXPECT_EQ(closed.FindKeyframe({kOwn, 87})->loop_edges.size(), 1u);
  EXPECT_LT(closed.points().size() + 50, drifting_.points().size());
}

TEST_F(LoopCloserTest, TheRootStays) {
  Load(drifting_);
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 87});
  StepUntilIdle(*closer);
  EXPECT_LT(Copy().FindKeyframe({kOwn, 0})->camera_from_map.translation.norm(), 1e-9);
}

TEST_F(LoopCloserTest, WhatIsWellConnectedIsNoLoop) {
  Load(drifting_);
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 40});
  StepUntilIdle(*closer);
  EXPECT_EQ(closer->counts().queried, 1);
  EXPECT_EQ(closer->counts().closed, 0);
  EXPECT_EQ(map_.corrections(), 0u);
}

TEST_F(LoopCloserTest, OthersKeyframesCloseALoopAndStay) {
  // The robot drifts along; another was at the far end, and is placed where the robot's start
  // says it is.
  const SyntheticMap own = MakeSyntheticMap(
      world_, PosesOnRing(0, 4, 60), {.local_map = kOwn, .seed = 5, .drift_yaw_rad = 0.0015});
  const SyntheticMap other =
      MakeSyntheticMap(world_, PosesOnRing(215, 4, 12), {.local_map = kOther, .seed = 6});
  const Rigid3d map_from_world = own.true_camera_from_world.at({kOwn, 0});
  const Rigid3d other_from_world = other.true_camera_from_world.at({kOther, 0});
  const Map placed = Moved(other.map, map_from_world * other_from_world.Inverse());
  Load(own.map);
  Load(placed);
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 57});
  const Map before = Copy();
  const double before_m = AteRmse_m(PosesOf(before), own.true_camera_from_world);
  StepUntilIdle(*closer);
  EXPECT_EQ(closer->counts().closed, 1);
  EXPECT_EQ(closer->counts().closed_against_others, 1);
  const Map closed = Copy();
  const double after_m = AteRmse_m(PosesOf(closed), own.true_camera_from_world);
  EXPECT_LT(after_m, 0.5 * before_m);
  RecordProperty("before_m", absl::StrCat(before_m));
  RecordProperty("after_m", absl::StrCat(after_m));
  SavePicture(before, closed, own);
  for (const auto& [id, keyframe] : placed.keyframes()) {
    EXPECT_EQ(closed.FindKeyframe(id)->camera_from_map.translation,
              keyframe.camera_from_map.translation);
  }
  size_t seen_by_own = 0;
  for (const auto& [id, point] : placed.points()) {
    ASSERT_NE(closed.FindPoint(id), nullptr);
    EXPECT_EQ(closed.FindPoint(id)->position_in_map, point.position_in_map);
    seen_by_own += closed.FindPoint(id)->observations.begin()->first.local_map == kOwn;
  }
  EXPECT_GT(seen_by_own, 50u);
  ASSERT_EQ(corrections_.size(), 2U) << "the loop and the adjustment";
  for (const OwnCorrection& correction : corrections_) {
    EXPECT_GE(correction.fixed.size(), 5U);
    for (const KeyframeId& id : correction.fixed) EXPECT_EQ(id.local_map, kOther);
  }
}

TEST_F(LoopCloserTest, SaysHowItMovedTheOwnMap) {
  Load(drifting_);
  const Map before = Copy();
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 87});
  StepUntilIdle(*closer);
  ASSERT_EQ(corrections_.size(), 2U) << "the loop and the adjustment";
  EXPECT_TRUE(corrections_[0].fixed.empty());
  const auto& closed = corrections_[0].motions.at({kOwn, 87});
  const auto& adjusted = corrections_[1].motions.at({kOwn, 87});
  EXPECT_EQ(closed.camera_from_map_before.translation,
            before.FindKeyframe({kOwn, 87})->camera_from_map.translation);
  EXPECT_EQ(closed.camera_from_map_after.translation, adjusted.camera_from_map_before.translation);
  EXPECT_EQ(adjusted.camera_from_map_after.translation,
            Copy().FindKeyframe({kOwn, 87})->camera_from_map.translation);
  EXPECT_FALSE(corrections_[0].motions.contains({kOwn, 0})) << "the root";
}

TEST_F(LoopCloserTest, WhatWasBornMeanwhileFollows) {
  Load(drifting_);
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 87});
  ASSERT_TRUE(closer->StepDetection());
  // Mapping goes on before it comes to the correction.
  const Map before = Copy();
  const Rigid3d newest_from_last{Eigen::Quaterniond::Identity(), {0, 0, -0.5}};
  map_.Write([&](Map& map) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(
        {kOwn, 88}, 88, 0, map.FindKeyframe({kOwn, 87})->payload->camera, Features());
    keyframe.camera_from_map = newest_from_last * map.FindKeyframe({kOwn, 87})->camera_from_map;
    keyframe.parent = {kOwn, 87};
    map.AddKeyframe(std::move(keyframe));
    map.RemoveKeyframe({kOwn, 50});
  });
  RunJobs();
  const Map after = Copy();
  const Rigid3d last = after.FindKeyframe({kOwn, 87})->camera_from_map;
  const Rigid3d newest = after.FindKeyframe({kOwn, 88})->camera_from_map;
  EXPECT_LT(((newest * last.Inverse()).translation - newest_from_last.translation).norm(), 1e-9);
  EXPECT_GT(
      (last.translation - before.FindKeyframe({kOwn, 87})->camera_from_map.translation).norm(),
      0.1);
}

TEST_F(LoopCloserTest, WorksFromTwoThreads) {
  Load(drifting_);
  const auto closer = MakeCloser();
  std::thread detection([&] {
    while (closer->WaitForDetection()) closer->StepDetection();
  });
  std::thread adjustment([&] {
    while (closer->WaitForAdjustment()) closer->StepAdjustment();
  });
  std::thread mapping([&] {
    while (queue_.WaitForWork()) RunJobs();
  });
  closer->Enqueue({kOwn, 40});
  closer->Enqueue({kOwn, 87});
  while (!closer->IsIdle()) std::this_thread::yield();
  closer->Stop();
  queue_.Stop();
  detection.join();
  adjustment.join();
  mapping.join();
  EXPECT_EQ(closer->counts().queried, 2);
  EXPECT_EQ(closer->counts().closed, 1);
  EXPECT_EQ(closer->counts().adjusted, 1);
}

TEST_F(LoopCloserTest, KeyframesThatAreGoneAreSkipped) {
  Load(drifting_);
  const auto closer = MakeCloser();
  closer->Enqueue({kOwn, 4711});
  EXPECT_TRUE(closer->StepDetection());
  EXPECT_FALSE(closer->StepDetection());
  EXPECT_EQ(closer->counts().closed, 0);
}

}  // namespace
}  // namespace corbslam::client_agent
