#include "slam/fusing/map_fusing.h"

#include <gtest/gtest.h>

#include "slam/fusing/testing/fused_maps.h"
#include "slam/fusing/testing/long_drive.h"
#include "slam/verification/place_verification.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam {
namespace {

using testing::AddDrive;
using testing::ApplyFusing;
using testing::AteRmse_m;
using testing::JoinTruth;
using testing::MakeRingWorld;
using testing::MakeSyntheticMap;
using testing::MeanReprojectionError_px2;
using testing::PosesOf;
using testing::PosesOnRing;
using testing::SayOverlap;
using testing::SyntheticMap;
using testing::SyntheticMapOptions;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};

// A goes from 0 to 87 degrees, B from 70.5 to 157.5: each drifts its own way.
class MapFusingTest : public ::testing::Test {
 protected:
  MapFusingTest()
      : world_(MakeRingWorld(3)),
        a_(MakeSyntheticMap(world_, PosesOnRing(0, 3, 30),
                            {.local_map = kA, .seed = 5, .drift_yaw_rad = 0.002})),
        b_(MakeSyntheticMap(world_, PosesOnRing(70.5, 3, 30),
                            {.local_map = kB, .seed = 6, .drift_scale = 0.01})) {}

  Overlap Verify(uint32_t query_of_b, uint32_t candidate_of_a) const {
    return VerifyPlace(b_.map, {kB, query_of_b}, a_.map, {kA, candidate_of_a}, {});
  }
  FuseMapsRequest MakeRequest(std::vector<Overlap> overlaps) const {
    FuseMapsRequest request;
    request.base_revision = 7;
    request.target = a_.map;
    request.source = b_.map;
    request.overlaps = std::move(overlaps);
    request.new_overlaps = {0};
    return request;
  }

  // Overlaps between A and B after `first` made them one island: `later` ones are new.
  FuseMapsRequest MakeLaterRequest(const FuseMapsResult& first, std::vector<Overlap> earlier,
                                   const std::vector<Overlap>& later) const {
    FuseMapsRequest request;
    request.target = ApplyFusing(a_.map, b_.map, first);
    for (size_t i = 0; i < later.size(); ++i) request.new_overlaps.push_back(earlier.size() + i);
    earlier.insert(earlier.end(), later.begin(), later.end());
    for (Overlap& overlap : earlier) {
      // A pair of points that became one says nothing any more.
      std::erase_if(overlap.inliers, [&request](const PointPair& pair) {
        return request.target.FindPoint(pair.query) == nullptr ||
               request.target.FindPoint(pair.candidate) == nullptr;
      });
    }
    request.overlaps = std::move(earlier);
    return request;
  }
  Overlap VerifyWrong(double x_m, double z_m) const {
    Overlap wrong = Verify(4, 28);
    wrong.candidate_from_query.translation += Eigen::Vector3d(x_m, 0, z_m);
    return wrong;
  }
  double AteOf(const FuseMapsRequest& request, const FuseMapsResult& result) const {
    return AteRmse_m(PosesOf(ApplyFusing(request.target, request.source, result)),
                     JoinTruth(a_, b_));
  }

  const testing::SyntheticWorld world_;
  const SyntheticMap a_;
  const SyntheticMap b_;
};

TEST_F(MapFusingTest, BringsTheSourceIntoTheTargetsFrame) {
  const auto result = FuseMaps(MakeRequest({Verify(2, 26)}), {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->accepted);
  EXPECT_EQ(result->base_revision, 7u);
  const Map fused = ApplyFusing(a_.map, b_.map, *result);
  const auto truth = JoinTruth(a_, b_);
  EXPECT_EQ(fused.keyframes().size(), truth.size());
  // One rigid alignment for both: as good as the two drifting maps are by themselves.
  const double apart_m = AteRmse_m(PosesOf(a_.map), a_.true_camera_from_world) +
                         AteRmse_m(PosesOf(b_.map), b_.true_camera_from_world);
  EXPECT_LT(AteRmse_m(PosesOf(fused), truth), 2.5 * apart_m + 0.05);
  EXPECT_EQ(result->target_from_source.scale, 1);
}

TEST_F(MapFusingTest, EveryKeyframeAndPointOfTheSourceHasAPlace) {
  const auto result = FuseMaps(MakeRequest({Verify(2, 26)}), {}, nullptr);
  ASSERT_TRUE(result.ok());
  size_t keyframes = 0;
  for (const KeyframePose& pose : result->poses) keyframes += pose.id.local_map == kB;
  EXPECT_EQ(keyframes, b_.map.keyframes().size());
  size_t points = result->merges.size();
  for (const PointPosition& position : result->positions) points += position.id.local_map == kB;
  EXPECT_EQ(points, b_.map.points().size());
}

TEST_F(MapFusingTest, DuplicatesBecomeTheTargetsPoint) {
  const auto result = FuseMaps(MakeRequest({Verify(2, 26)}), {}, nullptr);
  ASSERT_TRUE(result.ok());
  size_t right = 0;
  for (const FuseMapsResult::Merge& merge : result->merges) {
    ASSERT_EQ(merge.survivor.local_map, kA);
    ASSERT_EQ(merge.member.local_map, kB);
    right += a_.world_point.at(merge.survivor) == b_.world_point.at(merge.member);
  }
  EXPECT_GT(result->merges.size(), 100u);
  EXPECT_GE(right * 100, result->merges.size() * 98);
}

TEST_F(MapFusingTest, WeldingLowersTheReprojectionError) {
  const Overlap overlap = Verify(2, 26);
  const auto welded = FuseMaps(MakeRequest({overlap}), {}, nullptr);
  ASSERT_TRUE(welded.ok());
  // The same merges, but the source only moved as a whole.
  FuseMapsResult moved = *welded;
  moved.poses.clear();
  moved.positions.clear();
  for (const auto& [id, keyframe] : b_.map.keyframes()) {
    moved.poses.push_back({id, Similarity3d::FromRigid(keyframe.camera_from_map) *
                                   welded->target_from_source.Inverse()});
  }
  for (const auto& [id, point] : b_.map.points()) {
    moved.positions.push_back({id, welded->target_from_source * point.position_in_map});
  }
  EXPECT_LT(MeanReprojectionError_px2(ApplyFusing(a_.map, b_.map, *welded)),
            MeanReprojectionError_px2(ApplyFusing(a_.map, b_.map, moved)));
}

TEST_F(MapFusingTest, OverlapsMayBeNamedFromEitherSide) {
  Overlap turned = VerifyPlace(a_.map, {kA, 26}, b_.map, {kB, 2}, {});
  ASSERT_TRUE(turned.IsAccepted());
  const auto result = FuseMaps(MakeRequest({turned}), {}, nullptr);
  const auto straight = FuseMaps(MakeRequest({Verify(2, 26)}), {}, nullptr);
  ASSERT_TRUE(result.ok() && straight.ok());
  ASSERT_TRUE(result->accepted);
  EXPECT_LT(
      (result->target_from_source.translation - straight->target_from_source.translation).norm(),
      0.05);
  for (const auto& merge : result->merges) EXPECT_EQ(merge.survivor.local_map, kA);
}

TEST_F(MapFusingTest, AnOverlapThatContradictsTheOthersIsRefused) {
  FuseMapsRequest request = MakeRequest({Verify(2, 26), Verify(3, 27), VerifyWrong(6, 3)});
  request.new_overlaps = {0, 1, 2};
  const auto result = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_FALSE(result->accepted);
  EXPECT_GT(result->worst_edge_chi2, 50);
  EXPECT_TRUE(result->poses.empty());
}

TEST_F(MapFusingTest, AnEarlierOverlapThatWasWrongDoesNotRefuseALaterGoodOne) {
  const auto first = FuseMaps(MakeRequest({Verify(2, 26)}), {}, nullptr);
  ASSERT_TRUE(first.ok() && first->accepted);
  const FuseMapsRequest request =
      MakeLaterRequest(*first, {Verify(2, 26), VerifyWrong(6, 3)}, {Verify(3, 27)});
  const auto result = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->accepted);
  EXPECT_GT(result->worst_edge_chi2, 50);
  EXPECT_LT(AteOf(request, *result), AteOf(MakeRequest({}), *first) + 0.05);
}

TEST_F(MapFusingTest, ANewOverlapAgainstAnEarlierOneIsRefused) {
  const auto first = FuseMaps(MakeRequest({Verify(2, 26)}), {}, nullptr);
  ASSERT_TRUE(first.ok() && first->accepted);
  for (const double error_m : {2.0, 6.0, 20.0}) {
    const auto result =
        FuseMaps(MakeLaterRequest(*first, {Verify(2, 26)}, {VerifyWrong(error_m, 0)}), {}, nullptr);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_FALSE(result->accepted) << error_m;
  }
}

TEST_F(MapFusingTest, AnEarlierWrongOverlapYieldsToSeveralNewOnes) {
  const auto first = FuseMaps(MakeRequest({VerifyWrong(6, 3)}), {}, nullptr);
  ASSERT_TRUE(first.ok() && first->accepted);
  EXPECT_GT(AteOf(MakeRequest({}), *first), 1);
  const FuseMapsRequest request =
      MakeLaterRequest(*first, {VerifyWrong(6, 3)}, {Verify(2, 26), Verify(3, 27), Verify(1, 25)});
  const auto result = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->accepted);
  // What welding bent at the wrong place stays until the global adjustment.
  EXPECT_LT(AteOf(request, *result), 0.5);
}

TEST_F(MapFusingTest, MonocularMapsComeToOneScale) {
  const SyntheticMap a =
      MakeSyntheticMap(world_, PosesOnRing(0, 3, 30), {.local_map = kA, .scale = 1.5});
  const SyntheticMap b = MakeSyntheticMap(world_, PosesOnRing(70.5, 3, 30),
                                          {.local_map = kB, .seed = 2, .scale = 0.4});
  FuseMapsRequest request;
  request.target = a.map;
  request.source = b.map;
  request.fix_scale = false;
  request.overlaps = {VerifyPlace(b.map, {kB, 2}, a.map, {kA, 26}, {.fix_scale = false})};
  request.new_overlaps = {0};
  const auto result = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->accepted);
  EXPECT_NEAR(result->target_from_source.scale, 1.5 / 0.4, 0.05);
  std::map<KeyframeId, Rigid3d> fused = PosesOf(ApplyFusing(a.map, b.map, *result));
  for (auto& [id, pose] : fused) pose.translation /= 1.5;
  EXPECT_LT(AteRmse_m(fused, JoinTruth(a, b)), 0.2);
}

TEST_F(MapFusingTest, ClosesALoopInsideOneMap) {
  const SyntheticMap once_round = MakeSyntheticMap(
      world_, PosesOnRing(0, 4.1, 88), {.local_map = kA, .seed = 5, .drift_yaw_rad = 0.0015});
  // The last keyframe is 3.3 degrees before the first; both see the same, as different points.
  FuseMapsRequest request;
  request.target = testing::SplitPoints(once_round.map, 44);
  const Overlap loop = VerifyPlace(request.target, {kA, 87}, request.target, {kA, 0}, {});
  ASSERT_TRUE(loop.IsAccepted()) << ToString(loop.verdict);
  request.overlaps = {loop};
  request.new_overlaps = {0};
  const auto result = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->accepted);
  const Map closed = ApplyFusing(request.target, Map(), *result);
  EXPECT_LT(AteRmse_m(PosesOf(closed), once_round.true_camera_from_world),
            0.5 * AteRmse_m(PosesOf(request.target), once_round.true_camera_from_world));
  EXPECT_GT(result->merges.size(), 50u);
}

TEST_F(MapFusingTest, ALoopThatNoDriftExplainsIsRefused) {
  FuseMapsRequest request;
  request.target = a_.map;
  Overlap wrong;
  wrong.query = {kA, 29};
  wrong.candidate = {kA, 2};
  wrong.verdict = OverlapVerdict::kAccepted;
  request.overlaps = {wrong};
  request.new_overlaps = {0};
  const auto result = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_FALSE(result->accepted);
}

// Two drives that share half of their way, and six overlaps where the second begins, each aside by
// `error_m`.
FuseMapsRequest MeetingDrives(const Eigen::Vector3d& error_m) {
  FuseMapsRequest request;
  AddDrive(kA, 0, 60, /*depth_m=*/80, request.target);
  AddDrive(kB, 30, 60, /*depth_m=*/80, request.target);
  for (uint32_t k = 0; k < 6; ++k) {
    request.overlaps.push_back(SayOverlap(request.target, {kB, k}, {kA, 30 + k}, error_m));
  }
  return request;
}

// Eleven metres are little at the scene's depth of 80, but others agree on where the maps meet.
TEST(FusingGraphTest, ANewOverlapWithoutASayIsRefused) {
  FuseMapsRequest request = MeetingDrives({0, 0, 0});
  request.overlaps.push_back(SayOverlap(request.target, {kB, 3}, {kA, 33}, {0, 0, 0.5}));
  request.new_overlaps = {6};
  const auto good = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(good.ok()) << good.status();
  EXPECT_TRUE(good->accepted);
  request.overlaps[6] = SayOverlap(request.target, {kB, 3}, {kA, 33}, {0, 0, 11});
  const auto outvoted = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(outvoted.ok()) << outvoted.status();
  EXPECT_LT(outvoted->worst_edge_chi2, MapFusingOptions().max_edge_chi2);
  EXPECT_FALSE(outvoted->accepted);
}

// Half a metre is within the noise of a view at that depth.
TEST(FusingGraphTest, EarlierOverlapsThatTheMapAgreesWithDoNotMoveIt) {
  FuseMapsRequest request = MeetingDrives({0.5, 0, 0});
  request.overlaps.push_back(SayOverlap(request.target, {kB, 20}, {kA, 50}, {0, 0, 0}));
  request.new_overlaps = {6};
  const auto fused = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(fused.ok()) << fused.status();
  EXPECT_TRUE(fused->accepted);
  for (const KeyframePose& pose : fused->poses) {
    const Keyframe& before = *request.target.FindKeyframe(pose.id);
    EXPECT_LT((CameraCentre(pose.camera_from_map.ToRigid()) - CameraCentre(before.camera_from_map))
                  .norm(),
              1e-3)
        << ToString(pose.id);
  }
  // A new overlap that is equally wrong does move keyframes.
  request.new_overlaps = {0};
  const auto moved = FuseMaps(request, {}, nullptr);
  ASSERT_TRUE(moved.ok()) << moved.status();
  EXPECT_FALSE(moved->poses.empty());
}

// Two overlaps say different things; the one whose inliers know is believed.
TEST(FusingGraphTest, AnOverlapCountsByItsCovariance) {
  FuseMapsRequest request = MeetingDrives({0, 0, 0});
  request.overlaps.clear();
  for (const double error_m : {-0.5, 0.5}) {
    request.overlaps.push_back(SayOverlap(request.target, {kB, 3}, {kA, 33}, {error_m, 0, 0}));
  }
  request.new_overlaps = {0, 1};
  const auto shift_m = [&request] {
    const auto fused = FuseMaps(request, {}, nullptr);
    EXPECT_TRUE(fused.ok() && fused->accepted);
    for (const KeyframePose& pose : fused->poses) {
      if (pose.id != KeyframeId{kB, 3}) continue;
      return (CameraCentre(pose.camera_from_map.ToRigid()) -
              CameraCentre(request.target.FindKeyframe(pose.id)->camera_from_map))
          .x();
    }
    return 0.0;
  };
  const double undecided_m = shift_m();
  request.overlaps[0].covariance = 100 * Matrix7d::Identity();
  const double second_m = shift_m();
  std::swap(request.overlaps[0].covariance, request.overlaps[1].covariance);
  const double first_m = shift_m();
  EXPECT_GT(std::abs(second_m - first_m), 0.8);
  EXPECT_NEAR(undecided_m, (first_m + second_m) / 2, 0.1);
}

TEST_F(MapFusingTest, NonsenseIsRefusedByName) {
  FuseMapsRequest request = MakeRequest({Verify(2, 26)});
  request.new_overlaps = {4};
  EXPECT_EQ(FuseMaps(request, {}, nullptr).status().code(), absl::StatusCode::kInvalidArgument);
  request = MakeRequest({Verify(2, 26)});
  request.overlaps[0].candidate.index = 999;
  const absl::Status unknown = FuseMaps(request, {}, nullptr).status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(unknown.message().find(ToString(KeyframeId{kA, 999})), absl::string_view::npos);
  request = MakeRequest({Verify(2, 26)});
  request.overlaps[0].covariance(2, 2) = -1;
  EXPECT_EQ(FuseMaps(request, {}, nullptr).status().code(), absl::StatusCode::kInvalidArgument);
  request = MakeRequest({Verify(2, 26)});
  request.source = request.target;
  EXPECT_EQ(FuseMaps(request, {}, nullptr).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(MapFusingTest, CanBeCancelled) {
  const auto never = [](double) { return false; };
  EXPECT_EQ(FuseMaps(MakeRequest({Verify(2, 26)}), {}, never).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace corbslam
