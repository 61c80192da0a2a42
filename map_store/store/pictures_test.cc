// Tests which pictures of keyframes a store on a disk keeps, how long, and what it refuses; and
// what it says of an overlap's keypoints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/grey_jpeg.h"
#include "map_store/testing/sleeping_store.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;
using testing::MakeGreyJpeg;
using testing::TestAgent;

class PicturesTest : public testing::SleepingStore {
 protected:
  PicturesTest() { Begin(); }
  ~PicturesTest() override { robot_.reset(); }

  void Begin() {
    robot_ = std::make_unique<TestAgent>(*store_, kMission, "robot", map_a_);
    ASSERT_TRUE(robot_->Stream(10).ok());
  }
  // Ends the process and begins another one.
  void Restart() {
    robot_.reset();
    Open();
  }
  static std::string Jpeg(uint32_t index, size_t bytes = 1000) {
    return MakeGreyJpeg(100 + static_cast<int>(index), 96, bytes);
  }
  absl::Status Keep(uint32_t index, size_t bytes = 1000) {
    return store_->KeepPicture(robot_->session(), {{{0xa}, index}, Jpeg(index, bytes), 4});
  }
  // Ends the store, and reads what its journal has.
  std::unique_ptr<RocksJournal> OpenJournalAlone() {
    robot_.reset();
    store_.reset();
    auto journal = RocksJournal::Open({.directory = folder_.string()});
    EXPECT_TRUE(journal.ok()) << journal.status();
    Journal::Replay replay;
    replay.on_snapshot = [](MissionState) { return absl::OkStatus(); };
    replay.on_record = [](const JournalRecord&) { return absl::OkStatus(); };
    // A mission that is aside is opened by this.
    EXPECT_TRUE((*journal)->Recover(kMission, replay).ok());
    return *std::move(journal);
  }
  // Returns whether the keyframe's own picture is there.
  bool Has(uint32_t index, const std::string& mission = kMission) {
    const auto picture = store_->GetPicture(mission, {{0xa}, index});
    EXPECT_TRUE(picture.ok()) << picture.status();
    if (!picture.ok() || !picture->has_value()) return false;
    EXPECT_EQ((*picture)->jpeg.substr(0, 40), Jpeg(index).substr(0, 40));
    EXPECT_EQ((*picture)->scale, 4);
    return true;
  }

  std::unique_ptr<TestAgent> robot_;
};

TEST_F(PicturesTest, APictureOutlivesTheProcessAndSleep) {
  EXPECT_FALSE(Has(2));
  ASSERT_TRUE(Keep(2).ok());
  EXPECT_TRUE(Has(2));
  EXPECT_FALSE(Has(3));
  Restart();
  EXPECT_TRUE(Has(2));
  ASSERT_TRUE(store_->SleepMission(kMission).ok());
  EXPECT_TRUE(Has(2));
}

TEST_F(PicturesTest, ItCountsAsDisk) {
  const uint64_t before = store_->GetMission(kMission)->disk_bytes;
  for (uint32_t index = 0; index < 8; ++index) ASSERT_TRUE(Keep(index, 60000).ok());
  EXPECT_GE(store_->GetMission(kMission)->disk_bytes, before + 8 * 60000);
}

TEST_F(PicturesTest, BeyondTheLimitTheOldestGo) {
  robot_.reset();
  options_.max_picture_bytes_per_mission = 3500;
  Open();
  Begin();
  for (const uint32_t index : {5, 1, 7, 2}) ASSERT_TRUE(Keep(index).ok());
  EXPECT_FALSE(Has(5));
  for (const uint32_t index : {1, 7, 2}) EXPECT_TRUE(Has(index)) << index;
  Restart();
  // The order in which they came is known still.
  Begin();
  ASSERT_TRUE(Keep(3).ok());
  EXPECT_FALSE(Has(1));
  for (const uint32_t index : {7, 2, 3}) EXPECT_TRUE(Has(index)) << index;
}

TEST_F(PicturesTest, WithoutRoomForAnyNoneIsKeptAndRobotsAreToldSo) {
  robot_.reset();
  options_.max_picture_bytes_per_mission = 0;
  Open();
  SessionRequest request;
  request.mission = kMission;
  request.agent = "robot";
  const auto opened = store_->OpenSession(request);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_FALSE(opened->grant.capabilities.keyframe_pictures);
  EXPECT_TRUE(store_->KeepPicture(opened->session_id, {{{0xa}, 2}, Jpeg(2), 4}).ok());
  EXPECT_FALSE(Has(2));
}

TEST_F(PicturesTest, PicturesTakeAnEighthOfAMissionsDiskAtMost) {
  MissionProfile profile;
  profile.limits.disk_bytes = 8 * 2500;
  ASSERT_TRUE(store_->UpdateMission(kMission, profile, {ProfileField::kLimits}).ok());
  for (const uint32_t index : {1, 2, 3}) ASSERT_TRUE(Keep(index).ok());
  EXPECT_FALSE(Has(1));
  EXPECT_TRUE(Has(2));
  EXPECT_TRUE(Has(3));
}

TEST_F(PicturesTest, TheFirstOneOfAKeyframeStays) {
  ASSERT_TRUE(Keep(2).ok());
  EXPECT_TRUE(store_->KeepPicture(robot_->session(), {{{0xa}, 2}, Jpeg(9), 4}).ok());
  EXPECT_TRUE(Has(2));
}

TEST_F(PicturesTest, ItGoesWithItsKeyframe) {
  ASSERT_TRUE(Keep(3).ok());
  ASSERT_TRUE(Keep(4).ok());
  MapUpdateBatch batch = robot_->EmptyBatch();
  batch.removed_keyframes = {{{{0xa}, 3}, {{0xa}, 2}, {}}};
  ASSERT_TRUE(robot_->Send(batch).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->GetPicture(kMission, {{0xa}, 3}).status()));
  Restart();
  EXPECT_TRUE(Has(4));
  const auto journal = OpenJournalAlone();
  EXPECT_TRUE(absl::IsNotFound(journal->ReadPicture(kMission, {{0xa}, 3}).status()));
  EXPECT_TRUE(journal->ReadPicture(kMission, {{0xa}, 4}).ok());
}

TEST_F(PicturesTest, ItGoesWithALocalMapThatIsForgotten) {
  ASSERT_TRUE(Keep(3).ok());
  ASSERT_TRUE(robot_->Close().ok());
  store_->CloseSession(robot_->session());
  ForgetRequest request;
  request.agent = "robot";
  request.keep = 0;
  const auto forgotten = store_->ForgetLocalMaps(kMission, request);
  ASSERT_TRUE(forgotten.ok()) << forgotten.status();
  ASSERT_EQ(forgotten->local_maps.size(), 1u);
  Restart();
  EXPECT_TRUE(absl::IsNotFound(store_->GetPicture(kMission, {{0xa}, 3}).status()));
  const auto journal = OpenJournalAlone();
  int pictures = 0;
  const absl::Status counted = journal->ForEachPicture(kMission, [&](const KeyframePicture&) {
    ++pictures;
    return absl::OkStatus();
  });
  ASSERT_TRUE(counted.ok()) << counted;
  EXPECT_EQ(pictures, 0);
}

TEST_F(PicturesTest, ItGoesWithItsMissionAndMakesNone) {
  ASSERT_TRUE(Keep(3).ok());
  ASSERT_TRUE(store_->DeleteMission(kMission).ok());
  EXPECT_FALSE(Keep(4).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission(kMission).status()));
  robot_.reset();
  Begin();
  EXPECT_FALSE(Has(3)) << "another mission of the name has other pictures";
}

TEST_F(PicturesTest, AnotherRobotsKeyframeIsRefusedAndOneThatIsNotThereIsPassedOver) {
  TestAgent other(*store_, kMission, "other", map_b_);
  ASSERT_TRUE(other.Stream(3).ok());
  const absl::Status status = store_->KeepPicture(other.session(), {{{0xa}, 2}, Jpeg(2), 4});
  EXPECT_TRUE(absl::IsPermissionDenied(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("another agent's"));
  EXPECT_FALSE(Has(2));
  EXPECT_TRUE(Keep(13).ok()) << "its batch has not come";
  EXPECT_TRUE(store_->KeepPicture(robot_->session(), {{{0x77}, 2}, Jpeg(2), 4}).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(
      store_->KeepPicture(robot_->session(), {{{0xa}, 2}, "no picture", 4})));
  EXPECT_FALSE(Has(2));
}

TEST_F(PicturesTest, ARobotThatOnlyLocalisesSendsNone) {
  SessionRequest request;
  request.mission = kMission;
  request.agent = "guest";
  request.localise_only = true;
  const auto opened = store_->OpenSession(request);
  ASSERT_TRUE(opened.ok()) << opened.status();
  const absl::Status status = store_->KeepPicture(opened->session_id, {{{0xa}, 2}, Jpeg(2), 4});
  EXPECT_TRUE(absl::IsPermissionDenied(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("localise_only"));
}

// What two robots saw of one ring, fused by a worker that tells the truth.
class OverlapMatchesTest : public testing::SleepingStore {
 protected:
  OverlapMatchesTest() {
    worker_ = &truthful_;
    Open();
    Fill("pair", map_a_, "alpha");
    Fill("pair", map_b_, "bravo");
    EXPECT_TRUE(store_->RunFusionUntilIdle("pair").ok());
  }
  void Fill(const std::string& mission, const testing::SyntheticMap& map, const std::string& name) {
    TestAgent robot(*store_, mission, name, map);
    ASSERT_TRUE(robot.Stream().ok());
    ASSERT_TRUE(robot.Close().ok());
    store_->CloseSession(robot.session());
  }
};

TEST_F(OverlapMatchesTest, KeypointsOfAnAcceptedOverlapShowTheSame) {
  OverlapFilter filter;
  filter.accepted = true;
  const auto accepted = store_->ListOverlaps("pair", filter, {});
  ASSERT_TRUE(accepted.ok()) << accepted.status();
  ASSERT_FALSE(accepted->items.empty());
  EXPECT_TRUE(accepted->items[0].matches.empty()) << "lists have none";
  for (const OverlapInfo& listed : accepted->items) {
    const auto one = store_->GetOverlap("pair", listed.id);
    ASSERT_TRUE(one.ok()) << one.status();
    EXPECT_EQ(one->overlap.query, listed.overlap.query);
    EXPECT_GE(one->matches.size(), 20u);
    const auto query = store_->GetKeyframe("pair", listed.overlap.query);
    const auto candidate = store_->GetKeyframe("pair", listed.overlap.candidate);
    ASSERT_TRUE(query.ok() && candidate.ok());
    // Where the query's keypoint has a depth, the overlap's similarity puts it at the candidate's.
    const Camera& camera = *query->payload->camera;
    int checked = 0;
    for (const auto& [from, to] : one->matches) {
      for (const Keypoint& keypoint : query->payload->features.keypoints) {
        if (keypoint.Pixel() != from || !keypoint.HasDepth()) continue;
        const double depth = DepthFromDisparity(camera, keypoint.disparity_px);
        const Eigen::Vector3d there =
            listed.overlap.candidate_from_query *
            Eigen::Vector3d(depth * (from.x() - camera.cx_px) / camera.fx_px,
                            depth * (from.y() - camera.cy_px) / camera.fy_px, depth);
        EXPECT_LT((Project(camera, there) - to).norm(), 40);
        ++checked;
        break;
      }
    }
    EXPECT_GT(checked, 10);
  }
}

TEST_F(OverlapMatchesTest, OneThatIsNotThereIsSaidToBeMissing) {
  const absl::Status status = store_->GetOverlap("pair", 12345).status();
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("overlap 12345"));
}

}  // namespace
}  // namespace corbslam::map_store
