#include "slam/verification/place_verification.h"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/geometry/lie.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam {
namespace {

using testing::MakeRingWorld;
using testing::MakeSyntheticMap;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::SyntheticMapOptions;
using testing::SyntheticWorld;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};

class PlaceVerificationTest : public ::testing::Test {
 protected:
  PlaceVerificationTest() : world_(MakeRingWorld(3)), a_(MakeA()) {}

  SyntheticMap MakeA() const {
    return MakeSyntheticMap(world_, PosesOnRing(0, 3, 12), {.local_map = kA, .seed = 5});
  }
  // B passes the same ground with other keyframes.
  SyntheticMap MakeB(SyntheticMapOptions options = {}) const {
    options.local_map = kB;
    options.seed = 6;
    return MakeSyntheticMap(world_, PosesOnRing(13.5, 3, 12), options);
  }
  Overlap Verify(const SyntheticMap& b, PlaceVerificationOptions options = {}) const {
    return VerifyPlace(b.map, query_, a_.map, candidate_, options);
  }
  Rigid3d TrueCandidateFromQuery(const SyntheticMap& b) const {
    return a_.true_camera_from_world.at(candidate_) * b.true_camera_from_world.at(query_).Inverse();
  }
  void ExpectTruth(const SyntheticMap& b, const Overlap& overlap, double scale = 1) const {
    const Rigid3d truth = TrueCandidateFromQuery(b);
    const Similarity3d& found = overlap.candidate_from_query;
    EXPECT_LT((found.translation - truth.translation).norm(), 0.03);
    EXPECT_LT(RotationAngle(found.rotation.conjugate() * truth.rotation), 0.005);
    EXPECT_NEAR(found.scale * scale, 1, 0.02);
  }

  const SyntheticWorld world_;
  const SyntheticMap a_;
  const KeyframeId query_{kB, 2};      // It is at 19.5 degrees.
  const KeyframeId candidate_{kA, 6};  // It is at 18 degrees.
};

TEST_F(PlaceVerificationTest, FindsHowTheKeyframesStand) {
  const SyntheticMap b = MakeB();
  const Overlap overlap = Verify(b);
  ASSERT_EQ(ToString(overlap.verdict), "ACCEPTED");
  ExpectTruth(b, overlap);
  size_t right = 0;
  for (const PointPair& pair : overlap.inliers) {
    right += b.world_point.at(pair.query) == a_.world_point.at(pair.candidate);
  }
  EXPECT_GE(right * 100, overlap.inliers.size() * 98);
  EXPECT_EQ(overlap.evidence.refined_inliers, static_cast<int>(overlap.inliers.size()));
}

// The error has six degrees of freedom; the synthetic points have errors of their own besides the
// pixels'.
TEST_F(PlaceVerificationTest, KnowsHowFarItMayBeOff) {
  const SyntheticMap b = MakeB();
  const Overlap overlap = Verify(b);
  ASSERT_TRUE(overlap.IsAccepted());
  ASSERT_TRUE(IsCovariance(overlap.covariance));
  EXPECT_TRUE(overlap.covariance.row(6).isZero(0));
  const Matrix6d covariance = overlap.covariance.topLeftCorner<6, 6>();
  const Vector6d error =
      LogSE3(TrueCandidateFromQuery(b) * overlap.candidate_from_query.ToRigid().Inverse());
  EXPECT_LT(error.dot(covariance.inverse() * error), 60);
  // The result claims a certainty between a tenth of a millimetre and 5 cm.
  const double sigma_m = std::sqrt(covariance.diagonal().head(3).sum());
  EXPECT_GT(sigma_m, 1e-4);
  EXPECT_LT(sigma_m, 0.05);
}

TEST_F(PlaceVerificationTest, ChanceFindsFarLessThanTheRightPose) {
  const Overlap overlap = Verify(MakeB());
  ASSERT_TRUE(overlap.IsAccepted());
  EXPECT_LT(5 * overlap.evidence.chance_matches, overlap.evidence.projected_matches);
}

// The world's points all look like many others, so that some match wherever one looks.
TEST_F(PlaceVerificationTest, RefusesWhatChanceFindsAsWell) {
  SyntheticWorld alike = MakeRingWorld(3, 24000);
  for (size_t i = 0; i < alike.descriptors.size(); ++i) {
    if (i % 8 != 0) alike.descriptors[i] = alike.descriptors[i % 5];
  }
  const SyntheticMap a = MakeSyntheticMap(alike, PosesOnRing(0, 3, 12), {.local_map = kA});
  const SyntheticMap b = MakeSyntheticMap(alike, PosesOnRing(13.5, 3, 12), {.local_map = kB});
  const Overlap trusting =
      VerifyPlace(b.map, query_, a.map, candidate_, {.min_projected_to_chance = 0});
  ASSERT_EQ(ToString(trusting.verdict), "ACCEPTED");
  ASSERT_GT(2.5 * trusting.evidence.chance_matches, trusting.evidence.projected_matches);
  const Overlap overlap = VerifyPlace(b.map, query_, a.map, candidate_, {});
  EXPECT_EQ(ToString(overlap.verdict), "TOO_FEW_PROJECTED_MATCHES");
}

// Only a part of the other place looks the same, among much that looks like many things.
TEST_F(PlaceVerificationTest, RefusesAPlaceOfWhichOnlyAPartLooksTheSame) {
  SyntheticWorld here = MakeRingWorld(3, 24000);
  SyntheticWorld there = here;
  const SyntheticWorld other = MakeRingWorld(4, 24000);
  for (size_t i = 0; i < here.descriptors.size(); ++i) {
    if (i % 24 < 2) here.descriptors[i] = there.descriptors[i] = here.descriptors[i % 3];
    if (i % 24 > 3) there.descriptors[i] = other.descriptors[i];
  }
  const SyntheticMap a = MakeSyntheticMap(here, PosesOnRing(0, 3, 12), {.local_map = kA});
  const SyntheticMap b = MakeSyntheticMap(there, PosesOnRing(13.5, 3, 12), {.local_map = kB});
  const Overlap trusting =
      VerifyPlace(b.map, query_, a.map, candidate_, {.min_projected_share = 0});
  ASSERT_EQ(ToString(trusting.verdict), "ACCEPTED");
  ASSERT_LT(trusting.evidence.projected_matches, 0.1 * trusting.evidence.visible_points);
  const Overlap overlap = VerifyPlace(b.map, query_, a.map, candidate_, {});
  EXPECT_EQ(ToString(overlap.verdict), "TOO_FEW_PROJECTED_MATCHES");
}

TEST_F(PlaceVerificationTest, FindsItAmongAsManyMistakes) {
  const SyntheticMap b = MakeB({.share_of_mistaken = 0.5});
  const Overlap overlap = Verify(b);
  ASSERT_EQ(ToString(overlap.verdict), "ACCEPTED");
  ExpectTruth(b, overlap);
}

TEST_F(PlaceVerificationTest, TheOtherWayRoundIsTheInverse) {
  const SyntheticMap b = MakeB();
  const Overlap forth = Verify(b);
  const Overlap back = VerifyPlace(a_.map, candidate_, b.map, query_, {});
  ASSERT_TRUE(forth.IsAccepted());
  ASSERT_TRUE(back.IsAccepted());
  const Similarity3d circle = forth.candidate_from_query * back.candidate_from_query;
  EXPECT_LT(circle.translation.norm(), 0.03);
}

TEST_F(PlaceVerificationTest, EstimatesTheScaleOfAMonocularMap) {
  const SyntheticMap b = MakeB({.scale = 0.4});
  const Overlap overlap = Verify(b, {.fix_scale = false});
  ASSERT_EQ(ToString(overlap.verdict), "ACCEPTED");
  ExpectTruth(b, overlap, 0.4);
}

TEST_F(PlaceVerificationTest, RefusesAnotherWorld) {
  const SyntheticWorld other = MakeRingWorld(99);
  const SyntheticMap b = MakeSyntheticMap(other, PosesOnRing(13.5, 3, 12), {.local_map = kB});
  for (uint32_t candidate = 0; candidate < 12; ++candidate) {
    const Overlap overlap = VerifyPlace(b.map, query_, a_.map, {kA, candidate}, {});
    EXPECT_EQ(ToString(overlap.verdict), "TOO_FEW_WORD_MATCHES");
    EXPECT_TRUE(overlap.inliers.empty());
  }
}

TEST_F(PlaceVerificationTest, RefusesWhatLooksAlikeInAnotherShape) {
  SyntheticWorld other = MakeRingWorld(99);
  other.descriptors = world_.descriptors;
  const SyntheticMap b = MakeSyntheticMap(other, PosesOnRing(13.5, 3, 12), {.local_map = kB});
  int looked_alike = 0;
  for (uint32_t candidate = 0; candidate < 12; ++candidate) {
    const Overlap overlap = VerifyPlace(b.map, query_, a_.map, {kA, candidate}, {});
    EXPECT_FALSE(overlap.IsAccepted());
    looked_alike += overlap.evidence.word_matches >= 20;
  }
  EXPECT_GT(looked_alike, 0);
}

TEST_F(PlaceVerificationTest, RefusesOnePictureAlone) {
  // A poster hangs in two places: one keyframe of either map agrees, and no other.
  const SyntheticMapOptions lone{.local_map = kB, .seed = 6, .min_observations = 1};
  const SyntheticMap b = MakeSyntheticMap(world_, PosesOnRing(19.5, 3, 1), lone);
  const SyntheticMapOptions other{.local_map = kA, .seed = 5, .min_observations = 1};
  const SyntheticMap a = MakeSyntheticMap(world_, PosesOnRing(18, 3, 1), other);
  const Overlap overlap = VerifyPlace(b.map, {kB, 0}, a.map, {kA, 0}, {});
  EXPECT_EQ(ToString(overlap.verdict), "NO_SECOND_KEYFRAME");
  EXPECT_GE(overlap.evidence.projected_matches, 40);
}

TEST_F(PlaceVerificationTest, RefusesAMetricMapOfTheWrongScale) {
  SyntheticMap b = MakeB();
  const Map before = b.map;
  for (const auto& [id, keyframe] : before.keyframes()) {
    Rigid3d pose = keyframe.camera_from_map;
    pose.translation *= 1.2;
    b.map.SetPose(id, pose);
  }
  for (const auto& [id, point] : before.points()) {
    b.map.SetPosition(id, 1.2 * point.position_in_map);
    b.map.UpdatePointGeometry(id);
  }
  EXPECT_EQ(ToString(Verify(b, {.fix_scale = false}).verdict), "WRONG_SCALE");
}

// Two cameras at one place have the same pixels whatever the scale: pictures beside them tell it.
TEST_F(PlaceVerificationTest, TellsTheScaleWhereBothStandAtOnePlace) {
  for (const double scale : {0.01, 0.4, 100.0}) {
    const SyntheticMap b = MakeSyntheticMap(world_, PosesOnRing(12, 3, 12),
                                            {.local_map = kB, .seed = 6, .scale = scale});
    const Overlap overlap = Verify(b, {.fix_scale = false});
    ASSERT_EQ(ToString(overlap.verdict), "ACCEPTED") << scale;
    ExpectTruth(b, overlap, scale);
    EXPECT_GT(overlap.covariance(6, 6), 0);
    EXPECT_LT(std::sqrt(overlap.covariance(6, 6)), 0.005);
  }
}

TEST_F(PlaceVerificationTest, RefusesAScaleThatIsNotKnown) {
  const SyntheticMap b =
      MakeSyntheticMap(world_, PosesOnRing(12, 3, 12), {.local_map = kB, .seed = 6, .scale = 0.4});
  // Without neighbours nothing tells it.
  const PlaceVerificationOptions alone{
      .fix_scale = false, .neighbours = 0, .min_consistent_keyframes = 0};
  EXPECT_EQ(ToString(Verify(b, alone).verdict), "WRONG_SCALE");
  EXPECT_EQ(ToString(Verify(b, {.fix_scale = false, .max_log_scale_sigma = 1e-5}).verdict),
            "WRONG_SCALE");
}

TEST_F(PlaceVerificationTest, IsTheSameEveryTime) {
  const SyntheticMap b = MakeB({.share_of_mistaken = 0.3});
  const Overlap first = Verify(b);
  const Overlap second = Verify(b);
  EXPECT_EQ(first.candidate_from_query.translation, second.candidate_from_query.translation);
  EXPECT_EQ(first.inliers, second.inliers);
}

TEST_F(PlaceVerificationTest, UnknownKeyframesMatchNothing) {
  const Overlap overlap = VerifyPlace(Map(), query_, a_.map, candidate_, {});
  EXPECT_EQ(overlap.query, query_);
  EXPECT_FALSE(overlap.IsAccepted());
}

}  // namespace
}  // namespace corbslam
