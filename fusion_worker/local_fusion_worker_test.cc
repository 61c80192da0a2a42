#include "fusion_worker/local_fusion_worker.h"

#include <gtest/gtest.h>

#include <limits>

#include "slam/fusing/testing/fused_maps.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::fusion_worker {
namespace {

using testing::ApplyFusing;
using testing::AteRmse_m;
using testing::JoinTruth;
using testing::MakeRingWorld;
using testing::MakeSyntheticMap;
using testing::MeanReprojectionError_px2;
using testing::PosesOf;
using testing::PosesOnRing;
using testing::SyntheticMap;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};

class LocalFusionWorkerTest : public ::testing::Test {
 protected:
  LocalFusionWorkerTest()
      : world_(MakeRingWorld(3)),
        a_(MakeSyntheticMap(world_, PosesOnRing(0, 3, 20),
                            {.local_map = kA, .seed = 5, .drift_yaw_rad = 0.002})),
        b_(MakeSyntheticMap(world_, PosesOnRing(40.5, 3, 20),
                            {.local_map = kB, .seed = 6, .drift_scale = 0.01})) {}

  VerifyOverlapRequest VerifyRequest() const {
    VerifyOverlapRequest request;
    request.base_revision = 4;
    request.query_view = std::make_shared<const Map>(b_.map);
    request.query = {kB, 2};
    request.candidate_view = a_.map;
    // The first candidate is elsewhere, the second is right, the third is not looked at any more.
    request.candidates = {{{kA, 1}, 90}, {{kA, 15}, 70}, {{kA, 14}, 60}};
    return request;
  }
  AdjustBundleRequest AdjustRequest() const {
    AdjustBundleRequest request;
    request.base_revision = 9;
    request.view = a_.map;
    request.fixed = {{kA, 0}};
    return request;
  }

  const testing::SyntheticWorld world_;
  const SyntheticMap a_;
  const SyntheticMap b_;
  const std::unique_ptr<FusionWorker> worker_ = MakeLocalFusionWorker();
};

TEST_F(LocalFusionWorkerTest, CandidatesAreLookedAtUntilOneIsAccepted) {
  const auto result = worker_->VerifyOverlap(VerifyRequest(), nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->base_revision, 4u);
  ASSERT_EQ(result->overlaps.size(), 2u);
  EXPECT_FALSE(result->overlaps[0].IsAccepted());
  EXPECT_TRUE(result->overlaps[1].IsAccepted());
  EXPECT_EQ(result->overlaps[1].evidence.shared_words, 70);
}

TEST_F(LocalFusionWorkerTest, FromOverlapToOneAdjustedMap) {
  const auto verified = worker_->VerifyOverlap(VerifyRequest(), nullptr);
  ASSERT_TRUE(verified.ok());
  FuseMapsRequest fuse;
  fuse.target = a_.map;
  fuse.source = b_.map;
  fuse.overlaps = {verified->overlaps.back()};
  fuse.new_overlaps = {0};
  const auto fused = worker_->FuseMaps(fuse, nullptr);
  ASSERT_TRUE(fused.ok()) << fused.status();
  ASSERT_TRUE(fused->accepted);

  AdjustBundleRequest adjust;
  adjust.view = ApplyFusing(a_.map, b_.map, *fused);
  adjust.fixed = {{kA, 0}};
  const auto adjusted = worker_->AdjustBundle(adjust, nullptr);
  ASSERT_TRUE(adjusted.ok()) << adjusted.status();
  FuseMapsResult commit;
  commit.poses = adjusted->poses;
  commit.positions = adjusted->positions;
  commit.rejected = adjusted->rejected;
  const Map after = ApplyFusing(adjust.view, Map(), commit);
  // Keyframes and points went together: neither alone would lower the error.
  EXPECT_LT(MeanReprojectionError_px2(after), 0.5 * MeanReprojectionError_px2(adjust.view));
  EXPECT_LT(AteRmse_m(PosesOf(after), JoinTruth(a_, b_)),
            AteRmse_m(PosesOf(adjust.view), JoinTruth(a_, b_)));
  EXPECT_LT(AteRmse_m(PosesOf(after), JoinTruth(a_, b_)), 0.05);
}

TEST_F(LocalFusionWorkerTest, AdjustmentKeepsTheGauge) {
  const auto result = worker_->AdjustBundle(AdjustRequest(), nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->base_revision, 9u);
  EXPECT_EQ(result->keyframes, 20);
  EXPECT_LT(result->final_cost, result->initial_cost);
  EXPECT_EQ(result->poses.size(), 19u);
  for (const KeyframePose& pose : result->poses) EXPECT_NE(pose.id, (KeyframeId{kA, 0}));
}

TEST_F(LocalFusionWorkerTest, SaysHowFarItIsAndCanBeCancelled) {
  double last = 0;
  const auto follow = [&last](double part) {
    EXPECT_GE(part, 0);
    EXPECT_LE(part, 1);
    last = part;
    return true;
  };
  EXPECT_TRUE(worker_->AdjustBundle(AdjustRequest(), follow).ok());
  EXPECT_GT(last, 0);
  const auto never = [](double) { return false; };
  EXPECT_EQ(worker_->AdjustBundle(AdjustRequest(), never).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(worker_->VerifyOverlap(VerifyRequest(), never).status().code(),
            absl::StatusCode::kCancelled);
}

TEST_F(LocalFusionWorkerTest, NonsenseIsRefusedByName) {
  VerifyOverlapRequest verify = VerifyRequest();
  verify.candidates[1].id.index = 777;
  absl::Status status = worker_->VerifyOverlap(verify, nullptr).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find(ToString(KeyframeId{kA, 777})), absl::string_view::npos);

  AdjustBundleRequest adjust = AdjustRequest();
  adjust.fixed = {};
  EXPECT_EQ(worker_->AdjustBundle(adjust, nullptr).status().code(),
            absl::StatusCode::kInvalidArgument);
  adjust = AdjustRequest();
  adjust.max_iterations = 0;
  EXPECT_EQ(worker_->AdjustBundle(adjust, nullptr).status().code(),
            absl::StatusCode::kInvalidArgument);
  adjust = AdjustRequest();
  const MapPointId point = adjust.view.points().begin()->first;
  adjust.view.SetPosition(point, {0, std::numeric_limits<double>::quiet_NaN(), 0});
  status = worker_->AdjustBundle(adjust, nullptr).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find(ToString(point)), absl::string_view::npos);
  adjust = AdjustRequest();
  adjust.view = Map();
  EXPECT_EQ(worker_->AdjustBundle(adjust, nullptr).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(LocalFusionWorkerTest, TheSameRequestGivesTheSameBits) {
  const auto first = worker_->AdjustBundle(AdjustRequest(), nullptr);
  const auto second = MakeLocalFusionWorker()->AdjustBundle(AdjustRequest(), nullptr);
  ASSERT_TRUE(first.ok() && second.ok());
  ASSERT_EQ(first->poses.size(), second->poses.size());
  for (size_t i = 0; i < first->poses.size(); ++i) {
    EXPECT_EQ(first->poses[i].camera_from_map.translation,
              second->poses[i].camera_from_map.translation);
  }
}

}  // namespace
}  // namespace corbslam::fusion_worker
