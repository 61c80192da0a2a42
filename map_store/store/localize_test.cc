// Where was this picture taken: asked of the store, answered by a worker that works.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "map_store/store/map_store.h"
#include "map_store/testing/one_robots_store.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"
#include "slam/verification/frame_location.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;

constexpr char kMission[] = "m";

// Looks pictures up and does nothing else.
class LocatingWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest&,
                                                    const ProgressCallback&) override {
    return absl::UnavailableError("only pictures");
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest&,
                                          const ProgressCallback&) override {
    return absl::UnavailableError("only pictures");
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest&,
                                                  const ProgressCallback&) override {
    return absl::UnavailableError("only pictures");
  }
  absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& request,
                                                const ProgressCallback& progress) override {
    ++requests;
    for (const auto& candidate : request.candidates) {
      EXPECT_NE(request.view.FindKeyframe(candidate.id), nullptr);
    }
    return corbslam::LocateFrame(request, {}, progress);
  }
  absl::StatusOr<ExtractFeaturesResult> ExtractFeatures(
      const ExtractFeaturesRequest& request) override {
    if (request.encoded.empty()) return absl::InvalidArgumentError("the picture has 0 bytes");
    return seen;
  }

  ExtractFeaturesResult seen;
  int requests = 0;
};

// Robot A has mapped the ring from 0 to 52 degrees, robot B, which nobody has fused with it, from
// 180 on. Pictures are taken by a third one.
class LocalizeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(a_.Stream().ok());
    ASSERT_TRUE(b_.Stream().ok());
  }

  static Keyframe PictureOf(const SyntheticMap& map, uint32_t index) {
    const KeyframeId id = std::next(map.map.keyframes().begin(), index)->first;
    Keyframe frame;
    frame.payload = map.map.FindKeyframe(id)->payload;
    frame.points.resize(frame.keypoints().size());
    return frame;
  }
  static Rigid3d TruePose(const SyntheticMap& map, uint32_t index) {
    return std::next(map.true_camera_from_world.begin(), index)->second;
  }
  static LocalizeQuery Of(Keyframe picture) { return {.picture = std::move(picture), .prior = {}}; }
  LocalizeAnswer Ask(const LocalizeQuery& query) {
    const auto answer = store_.Localize(kMission, query, nullptr);
    EXPECT_TRUE(answer.ok()) << answer.status();
    return answer.value_or(LocalizeAnswer());
  }
  // The island's frame is that of its first camera.
  static double Error(const LocalizeAnswer& answer, const SyntheticMap& island,
                      const Rigid3d& camera_from_world) {
    const Rigid3d truth = camera_from_world * TruePose(island, 0).Inverse();
    const Rigid3d error = answer.camera_from_island * truth.Inverse();
    return error.translation.norm() + RotationAngle(error.rotation);
  }

  const SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14, 0);
  const SyntheticMap map_b_ = MakeRingMap(0xb, 180, 14, 0);
  const SyntheticMap near_a_ = MakeRingMap(0xc, 14, 8, 0);
  const SyntheticMap near_b_ = MakeRingMap(0xd, 194, 8, 0);
  const SyntheticMap nowhere_ = MakeRingMap(0xe, 100, 4, 0);
  LocatingWorker worker_;
  MapStore store_{testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                  std::make_unique<InMemoryJournal>(), &worker_};
  TestAgent a_{store_, kMission, "a", map_a_};
  TestAgent b_{store_, kMission, "b", map_b_};
};

TEST_F(LocalizeTest, FindsAPictureInTheGlobalFrame) {
  const LocalizeAnswer answer = Ask(Of(PictureOf(near_a_, 3)));
  ASSERT_EQ(ToString(answer.stage), "LOCATED");
  EXPECT_LT(Error(answer, map_a_, TruePose(near_a_, 3)), 0.1);
  EXPECT_TRUE(answer.in_reference_island);
  EXPECT_EQ(answer.island, (IslandId{0xa}));
  EXPECT_GE(answer.inliers, 30);
  EXPECT_TRUE(answer.covariance.has_value());
  ASSERT_FALSE(answer.keyframes.empty());
  EXPECT_EQ(answer.keyframes[0].local_map, (LocalMapId{0xa}));
  EXPECT_EQ(worker_.requests, 1);
}

TEST_F(LocalizeTest, LooksInOtherIslandsWhereItMay) {
  LocalizeQuery query = Of(PictureOf(near_b_, 3));
  EXPECT_LT(Ask(query).stage, LocateStage::kLocated);
  query.all_islands = true;
  const LocalizeAnswer answer = Ask(query);
  ASSERT_EQ(ToString(answer.stage), "LOCATED");
  EXPECT_FALSE(answer.in_reference_island);
  EXPECT_EQ(answer.island, (IslandId{0xb}));
  EXPECT_LT(Error(answer, map_b_, TruePose(near_b_, 3)), 0.1);
}

TEST_F(LocalizeTest, SaysThatItDoesNotKnowAPlace) {
  LocalizeQuery query = Of(PictureOf(nowhere_, 1));
  query.all_islands = true;
  const LocalizeAnswer answer = Ask(query);
  EXPECT_LT(answer.stage, LocateStage::kLocated) << answer.inliers;
  EXPECT_TRUE(answer.keyframes.empty());
}

TEST_F(LocalizeTest, APriorLeavesOutWhatIsFar) {
  LocalizeQuery query = Of(PictureOf(near_a_, 3));
  const Rigid3d truth = TruePose(near_a_, 3) * TruePose(map_a_, 0).Inverse();
  query.prior = PosePrior{truth, 3};
  EXPECT_EQ(ToString(Ask(query).stage), "LOCATED");
  Rigid3d far = truth;
  far.translation += far.rotation * Eigen::Vector3d(0, -100, 0);
  query.prior = PosePrior{far, 3};
  EXPECT_EQ(ToString(Ask(query).stage), "NO_CANDIDATES");
  // Keyframes are near enough, and the picture's own place is not.
  Rigid3d beside = truth;
  beside.translation += far.rotation * Eigen::Vector3d(0, -2.2, 0);
  query.prior = PosePrior{beside, 2};
  EXPECT_EQ(ToString(Ask(query).stage), "OUTSIDE_PRIOR");
}

TEST_F(LocalizeTest, AWorkerFindsThePicturesFeatures) {
  const Keyframe picture = PictureOf(near_a_, 3);
  worker_.seen = {picture.payload->features, picture.camera()};
  LocalizeQuery query{.picture = ExtractFeaturesRequest{.encoded = "x", .camera = {}}, .prior = {}};
  EXPECT_EQ(ToString(Ask(query).stage), "LOCATED");
  worker_.seen.features = {};
  EXPECT_EQ(ToString(Ask(query).stage), "FEW_FEATURES");
  query.picture = ExtractFeaturesRequest();
  EXPECT_THAT(std::string(store_.Localize(kMission, query, nullptr).status().message()),
              HasSubstr("0 bytes"));
}

TEST_F(LocalizeTest, ChangesNothing) {
  const auto before = store_.GetStatistics(kMission);
  Ask(Of(PictureOf(near_a_, 2)));
  const auto after = store_.GetStatistics(kMission);
  EXPECT_EQ(before->keyframes, after->keyframes);
  EXPECT_EQ(before->overlaps_queried, after->overlaps_queried);
  EXPECT_EQ(before->revision, after->revision);
}

TEST_F(LocalizeTest, NamesWhatIsMissing) {
  const LocalizeQuery query = Of(PictureOf(near_a_, 3));
  EXPECT_TRUE(absl::IsNotFound(store_.Localize("other", query, nullptr).status()));
  const MapStore without(testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                         std::make_unique<InMemoryJournal>(), nullptr);
  EXPECT_TRUE(absl::IsNotFound(without.Localize(kMission, query, nullptr).status()));
  const auto cancelled = store_.Localize(kMission, query, [] { return false; });
  EXPECT_TRUE(absl::IsCancelled(cancelled.status())) << cancelled.status();
}

class LocatingTruthfulWorker : public testing::TruthfulWorker {
 public:
  using TruthfulWorker::TruthfulWorker;
  absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& request,
                                                const ProgressCallback& progress) override {
    return corbslam::LocateFrame(request, {}, progress);
  }
};

// Two islands become one while a picture is looked up: its candidates were found in the one, and
// stand in the other's frame by the time they are compared.
TEST(LocalizeWhileFusingTest, SaysInWhoseFrameItFound) {
  const SyntheticMap map_a = MakeRingMap(0xa, 0, 14, 0);
  const SyntheticMap map_b = MakeRingMap(0xb, 30, 14, 0);
  LocatingTruthfulWorker worker{{&map_a, &map_b}};
  MapStore store(testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                 std::make_unique<InMemoryJournal>(), &worker);
  TestAgent a(store, kMission, "a", map_a);
  TestAgent b(store, kMission, "b", map_b);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  // Only B was there.
  const auto taken = std::next(map_b.map.keyframes().begin(), 12);
  LocalizeQuery query{.picture = Keyframe(), .prior = {}, .all_islands = true};
  Keyframe& picture = std::get<Keyframe>(query.picture);
  picture.payload = taken->second.payload;
  picture.points.resize(picture.keypoints().size());
  int asked = 0;
  const auto answer = store.Localize(kMission, query, [&] {
    if (++asked == 2) {
      EXPECT_TRUE(store.RunFusionUntilIdle(kMission).ok());
    }
    return true;
  });
  ASSERT_TRUE(answer.ok()) << answer.status();
  ASSERT_GE(asked, 2);
  ASSERT_EQ(store.GetMission(kMission)->islands, 1u);
  ASSERT_EQ(ToString(answer->stage), "LOCATED");
  EXPECT_TRUE(answer->in_reference_island);
  EXPECT_EQ(answer->island, (IslandId{0xa}));
  const Rigid3d truth = std::next(map_b.true_camera_from_world.begin(), 12)->second *
                        map_a.true_camera_from_world.begin()->second.Inverse();
  EXPECT_LT((answer->camera_from_island * truth.Inverse()).translation.norm(), 0.1);
}

// Three of a robot's sessions became one local map; a worker that looks pictures up has what that
// store left.
TEST(LocalizeInJoinedTest, FindsPlacesOfEachPart) {
  testing::OneRobotsStore robot(true);
  robot.StartAll();
  ASSERT_EQ(robot.store().GetMission(kMission)->local_maps, 2u);
  LocatingWorker worker;
  MapStore store(testing::OneRobotsStore::Options(true), testing::TheWorld().vocabulary,
                 std::make_unique<testing::ByteJournal>(robot.bytes()), &worker);
  ASSERT_TRUE(testing::RecoverUndamaged(store).ok());
  for (const size_t session : {0, 1, 2}) {
    const SyntheticMap& drive = robot.drives()[session];
    const KeyframeId id = std::next(drive.map.keyframes().begin(), 4)->first;
    // The keyframe itself is asked for: the same place in the same session.
    Keyframe picture;
    picture.payload = drive.map.FindKeyframe(id)->payload;
    picture.points.resize(picture.keypoints().size());
    const auto answer = store.Localize(kMission, {.picture = picture, .prior = {}}, nullptr);
    ASSERT_TRUE(answer.ok()) << answer.status();
    ASSERT_EQ(ToString(answer->stage), "LOCATED") << ToString(id);
    EXPECT_EQ(answer->island, (IslandId{1}));
    // It says where fusion has that keyframe.
    const auto keyframe = store.GetKeyframe(kMission, id);
    ASSERT_TRUE(keyframe.ok()) << "ids stay";
    const Rigid3d error =
        answer->camera_from_island * keyframe->camera_from_island.ToRigid().Inverse();
    EXPECT_LT(error.translation.norm() + RotationAngle(error.rotation), 0.1);
  }
}

}  // namespace
}  // namespace corbslam::map_store
