#include "client_agent/link/store_link.h"

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "gtest/gtest.h"
#include "slam/exchange/session_end.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};

class StoreLinkTest : public testing::Test {
 protected:
  StoreLinkTest() {
    StoreLinkOptions options;
    options.mission = "m";
    options.agent = "alpha";
    options.min_backoff = absl::ZeroDuration();
    options.max_backoff = absl::ZeroDuration();
    options.hold_newest_keyframes = 0;
    options.clock = [this] { return absl::Now() + passed_; };
    options.on_event = [this](LinkEvent event, LocalMapId local_map) {
      events_.emplace_back(event, local_map);
    };
    manager_ = std::make_unique<StoreLink>(options, &uplink_,
                                           [](const auto&) { return std::make_shared<Words>(); });
    Begin(kOwn);
  }

  void Begin(LocalMapId id) {
    map_ = maps_.emplace_back(std::make_unique<GuardedMap>(id)).get();
    manager_->BeginLocalMap(*map_, jobs_);
  }

  void AddKeyframe(KeyframeId id) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(id, 0, 0, std::make_shared<Camera>(), {});
    map_->Write([&](Map& map) { map.AddKeyframe(keyframe); });
  }

  absl::Duration passed_;
  std::vector<std::pair<LinkEvent, LocalMapId>> events_;
  FakeUplink uplink_;
  FakeMapJobs jobs_;
  // The link reads a map that ended until all of it is in batches.
  std::vector<std::unique_ptr<GuardedMap>> maps_;
  GuardedMap* map_ = nullptr;
  std::unique_ptr<StoreLink> manager_;
};

TEST_F(StoreLinkTest, SendsEveryKeyframeOnce) {
  for (uint32_t k = 0; k < 20; ++k) {
    AddKeyframe({kOwn, k});
    manager_->Step();
  }
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  size_t keyframes = 0;
  for (const auto& batch : uplink_.stored[kOwn]) keyframes += batch.full_keyframes.size();
  EXPECT_EQ(keyframes, 20U);
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
}

TEST_F(StoreLinkTest, ResumesAfterABreakWithoutLossOrRepetition) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  // The batch is stored, but the acknowledgement is lost with the link.
  uplink_.acknowledge = false;
  AddKeyframe({kOwn, 1});
  manager_->Step();
  uplink_.reachable = false;
  uplink_.Break(absl::UnavailableError("cut"));
  AddKeyframe({kOwn, 2});
  manager_->Step();
  manager_->Step();
  EXPECT_GT(manager_->upload().memory_bytes, 0U);
  uplink_.reachable = true;
  uplink_.acknowledge = true;
  manager_->Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  ASSERT_EQ(uplink_.stored[kOwn].size(), 4U);
  EXPECT_EQ(uplink_.stored[kOwn][2].full_keyframes.at(0).payload->id, (KeyframeId{kOwn, 2}));
  EXPECT_EQ(uplink_.requests.back().local_maps, (std::vector<LocalMapId>{kOwn}));
}

TEST_F(StoreLinkTest, SaysWhenTheLocalMapJoinsOthersAndWhenItLeavesThem) {
  using Events = std::vector<std::pair<LinkEvent, LocalMapId>>;
  AddKeyframe({kOwn, 0});
  manager_->Step();
  SharedUpdate alone;
  alone.global_from_local = Similarity3d::Identity();
  uplink_.Share(alone);
  EXPECT_TRUE(events_.empty()) << "it is still alone";
  SharedUpdate merged;
  merged.own_keyframes.push_back({{kOwn, 0}, Similarity3d(), Rigid3d()});
  uplink_.Share(merged);
  uplink_.Share(merged);
  EXPECT_EQ(events_, (Events{{LinkEvent::kMerged, kOwn}})) << "once";
  // A session that begins again is told all again.
  merged.restart = true;
  uplink_.Share(merged);
  EXPECT_EQ(events_.size(), 1u);
  SharedUpdate forget;
  forget.restart = true;
  uplink_.Share(forget);
  EXPECT_EQ(events_.back(), (Events::value_type{LinkEvent::kSplit, kOwn}));
  merged.apart = true;
  uplink_.Share(merged);
  merged.apart = false;
  uplink_.Share(merged);
  EXPECT_EQ(events_.size(), 4u);
  EXPECT_EQ(events_.back().first, LinkEvent::kMerged) << "with the mission's global frame";
  Begin({2});
  manager_->Step();
  uplink_.Share(forget);
  EXPECT_EQ(events_.size(), 4u) << "the new local map was never with others";
}

TEST_F(StoreLinkTest, SaysThatTheMissionWasDeletedAndOfNoOtherEndThatItWas) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  uplink_.Break(absl::UnavailableError("cut"));
  uplink_.Break(absl::AbortedError("a newer session of agent alpha"));
  EXPECT_TRUE(events_.empty());
  uplink_.Break(MissionDeletedError("m"));
  ASSERT_EQ(events_.size(), 1u);
  EXPECT_EQ(events_[0].first, LinkEvent::kMissionDeleted);
}

TEST_F(StoreLinkTest, AFencedAgentAsksAgainButNotAtOnce) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  uplink_.Break(absl::AbortedError("another session of agent alpha"));
  manager_->Step();
  EXPECT_EQ(uplink_.requests.size(), 1U);
  EXPECT_TRUE(absl::IsAborted(manager_->Finish(absl::Seconds(1))));
  passed_ += absl::Minutes(2);
  manager_->Step();
  EXPECT_EQ(uplink_.requests.size(), 2U);
}

// Somebody took the robot's right away by mistake, and gave it back.
TEST_F(StoreLinkTest, ARefusalIsNotForTheLifeOfTheProcess) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  uplink_.refusal = absl::PermissionDeniedError("its certificate is of no robot of this mission");
  uplink_.Break(uplink_.refusal);
  AddKeyframe({kOwn, 1});
  for (int minute = 0; minute < 60; ++minute) {
    manager_->Step();
    EXPECT_EQ(manager_->upload().hold, UplinkHold::kRefused);
    passed_ += absl::Minutes(1);
  }
  EXPECT_GT(uplink_.requests.size(), 25u) << "every two minutes at least";
  EXPECT_LT(uplink_.requests.size(), 65u) << "but rarely";
  uplink_.refusal = absl::OkStatus();
  passed_ += absl::Minutes(2);
  manager_->Step();
  EXPECT_EQ(manager_->upload().hold, UplinkHold::kNone);
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(uplink_.stored[kOwn].at(1).full_keyframes.size(), 1u);
}

TEST_F(StoreLinkTest, NobodyJoinsAMissionAgainThatWasDeleted) {
  uplink_.mission_uid = "first";
  AddKeyframe({kOwn, 0});
  manager_->Step();
  EXPECT_EQ(uplink_.requests.at(0).mission_uid, "") << "it has been in no mission yet";
  uplink_.Break(absl::UnavailableError("cut"));
  manager_->Step();
  EXPECT_EQ(uplink_.requests.at(1).mission_uid, "first");
  // While the robot was away the mission was deleted, and another one of its name was created.
  uplink_.refusal = MissionDeletedError("m");
  uplink_.Break(absl::UnavailableError("cut"));
  manager_->Step();
  EXPECT_EQ(uplink_.requests.at(2).mission_uid, "first");
  uplink_.refusal = absl::OkStatus();
  passed_ += absl::Hours(100);
  manager_->Step();
  EXPECT_EQ(uplink_.requests.size(), 3u);
  ASSERT_EQ(events_.size(), 1u);
  EXPECT_EQ(events_[0].first, LinkEvent::kMissionDeleted);
  EXPECT_TRUE(absl::IsAborted(manager_->Finish(absl::Seconds(1))));
}

// Another process has the robot's name, but it may end.
TEST_F(StoreLinkTest, ARobotWhoseNameIsTakenTriesAgain) {
  uplink_.reachable = false;
  AddKeyframe({kOwn, 0});
  manager_->Step();
  uplink_.Break(absl::AlreadyExistsError("connected already, as another process"));
  manager_->Step();
  const absl::Status unfinished = manager_->Finish(absl::Milliseconds(10));
  EXPECT_TRUE(absl::IsDeadlineExceeded(unfinished)) << unfinished;
  uplink_.reachable = true;
  manager_->Step();
  manager_->Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
}

TEST_F(StoreLinkTest, SaysWhyNothingGoesUp) {
  EXPECT_EQ(manager_->upload().hold, UplinkHold::kOpening);
  uplink_.reachable = false;
  AddKeyframe({kOwn, 0});
  manager_->Step();
  EXPECT_EQ(manager_->upload().hold, UplinkHold::kAway);
  uplink_.refusal = absl::ResourceExhaustedError("mission m has 5 keyframes; that is the limit");
  manager_->Step();
  EXPECT_EQ(manager_->upload().hold, UplinkHold::kNoRoom);
  EXPECT_GT(manager_->upload().memory_bytes, 0u);
  uplink_.refusal = absl::AlreadyExistsError("connected already, as another process");
  manager_->Step();
  EXPECT_EQ(manager_->upload().hold, UplinkHold::kRefused);
  uplink_.refusal = absl::OkStatus();
  uplink_.reachable = true;
  manager_->Step();
  EXPECT_EQ(manager_->upload().hold, UplinkHold::kNone);
}

TEST_F(StoreLinkTest, FinishSaysWhenTheStoreIsNotReached) {
  uplink_.reachable = false;
  AddKeyframe({kOwn, 0});
  EXPECT_TRUE(absl::IsDeadlineExceeded(manager_->Finish(absl::Milliseconds(10))));
}

TEST_F(StoreLinkTest, ANewLocalMapClosesTheOldOneAndAsksForEverythingAgain) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  SharedUpdate update;
  update.revision = 9;
  uplink_.Share(update);
  const LocalMapId second{2};
  Begin(second);
  AddKeyframe({second, 0});
  manager_->Step();
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  EXPECT_EQ(uplink_.stored[second].size(), 1U);
  EXPECT_EQ(uplink_.requests.back().last_revision, 0U);
}

// Its threads may still be at work when the robot goes on in another one.
TEST_F(StoreLinkTest, ALocalMapIsClosedOnceItIsWrittenNoMore) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  GuardedMap* const first = map_;
  const LocalMapId second{2};
  map_ = maps_.emplace_back(std::make_unique<GuardedMap>(second)).get();
  manager_->BeginLocalMap(*map_, jobs_, nullptr, StoreLink::Earlier::kMayStillBeWritten);
  AddKeyframe({second, 0});
  manager_->Step();
  EXPECT_FALSE(uplink_.stored[kOwn].back().closes_local_map);
  EXPECT_TRUE(manager_->Reads(kOwn));
  Keyframe late;
  late.payload = MakeKeyframePayload({kOwn, 1}, 0, 0, std::make_shared<Camera>(), {});
  first->Write([&](Map& map) { map.AddKeyframe(late); });
  manager_->EndLocalMap(kOwn);
  manager_->Step();
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  EXPECT_EQ(uplink_.stored[kOwn].at(1).full_keyframes.size(), 1u) << "what was mapped last";
  EXPECT_FALSE(manager_->Reads(kOwn));
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
}

TEST_F(StoreLinkTest, WhatIsStillToldOfAMapThatEndedStaysOutOfTheNextOne) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  const LocalMapId second{2};
  Begin(second);
  SharedUpdate update;
  update.revision = 9;
  uplink_.Share(update);
  EXPECT_EQ(jobs_.size(), 0U);
  AddKeyframe({second, 0});
  manager_->Step();
  uplink_.Break(absl::UnavailableError("cut"));
  manager_->Step();
  EXPECT_EQ(uplink_.requests.back().last_revision, 0U);
  uplink_.Share(update);
  EXPECT_EQ(jobs_.size(), 1U);
}

// A session that begins anew before the local map's first keyframe is still told of the one before.
TEST_F(StoreLinkTest, TheOldMapsPlaceIsNotTheNewOnes) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  const LocalMapId second{2};
  Begin(second);
  manager_->Step();
  ASSERT_EQ(uplink_.requests.size(), 2U);
  SharedUpdate place;
  place.revision = 9;
  place.global_from_local = Similarity3d::Identity();
  uplink_.Share(place);
  EXPECT_EQ(jobs_.size(), 0U);
  AddKeyframe({second, 0});
  manager_->Step();
  uplink_.Share(place);
  EXPECT_EQ(jobs_.size(), 1U);
}

// A batch of the new local map is under way while the store still tells of the one before.
TEST_F(StoreLinkTest, AnUpdateThatNamesTheOldMapIsPassedOver) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  const LocalMapId second{2};
  Begin(second);
  AddKeyframe({second, 0});
  manager_->Step();
  SharedUpdate place;
  place.revision = 9;
  place.local_map = kOwn;
  place.own_keyframes.push_back({{kOwn, 0}, Similarity3d(), Rigid3d()});
  uplink_.Share(place);
  EXPECT_EQ(jobs_.size(), 0U);
  EXPECT_TRUE(events_.empty()) << "the new local map has merged with nothing";
  place.local_map = second;
  place.own_keyframes = {{{second, 0}, Similarity3d(), Rigid3d()}};
  uplink_.Share(place);
  EXPECT_EQ(jobs_.size(), 1U);
  EXPECT_EQ(events_.size(), 1U);
}

// Fusion goes on when the drive has ended: robots that stay for it are told.
TEST_F(StoreLinkTest, WhatComesWhenAllIsAcknowledgedIsTaken) {
  AddKeyframe({kOwn, 0});
  ASSERT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  SharedUpdate place;
  place.revision = 9;
  place.global_from_local = Similarity3d::Identity();
  uplink_.Share(place);
  EXPECT_EQ(jobs_.size(), 1U);
}

// Returns an update by which fusion has placed the keyframe 5 m from where it is in the robot's
// frame.
SharedUpdate PlaceOfTheFirstKeyframe() {
  SharedUpdate update;
  update.revision = 9;
  update.own_keyframes.push_back({{kOwn, 0}, {1, Eigen::Quaterniond::Identity(), {5, 0, 0}}, {}});
  return update;
}

TEST_F(StoreLinkTest, SharedUpdatesReachTheMapThroughItsWriter) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  const SharedUpdate update = PlaceOfTheFirstKeyframe();
  uplink_.Share(update);
  uplink_.Share(update);
  EXPECT_FALSE(manager_->GlobalFromLocal().has_value());
  ASSERT_EQ(jobs_.size(), 1U) << "the second update rides along";
  jobs_.Run(*map_);
  EXPECT_NEAR(manager_->GlobalFromLocal()->translation.x(), -5, 1e-12);
  uplink_.Break(absl::UnavailableError("cut"));
  manager_->Step();
  EXPECT_EQ(uplink_.requests.back().last_revision, 9U);
}

TEST_F(StoreLinkTest, WhatIsPlacedGoesWithACorrectionOfItsOwnLocalMapAlone) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  const SharedUpdate update = PlaceOfTheFirstKeyframe();
  uplink_.Share(update);
  ASSERT_EQ(jobs_.size(), 1U);
  jobs_.Run(*map_);
  OwnCorrection correction;
  correction.motions[{kOwn, 0}] = {Rigid3d(), {Eigen::Quaterniond::Identity(), {-2, 0, 0}}};
  const auto correct = [&](LocalMapId id) { manager_->OnCorrected(id, correction, *map_); };
  correct({kOwn.value + 1});
  EXPECT_NEAR(manager_->GlobalFromLocal()->translation.x(), -5, 1e-12);
  // The keyframe is 2 m further along x in the robot's frame now, and where it was in the global
  // one.
  correct(kOwn);
  EXPECT_NEAR(manager_->GlobalFromLocal()->translation.x(), -7, 1e-12);
}

TEST_F(StoreLinkTest, AStoreThatMovesNoPointsIsNotToldThatItShall) {
  uplink_.capabilities = {};
  AddKeyframe({kOwn, 0});
  // This batch is made before a session stands.
  uplink_.reachable = false;
  manager_->Step();
  uplink_.reachable = true;
  manager_->Step();
  AddKeyframe({kOwn, 1});
  manager_->Step();
  ASSERT_EQ(uplink_.stored[kOwn].size(), 2u);
  EXPECT_FALSE(uplink_.stored[kOwn].back().points_follow);
  const LocalMapId second{2};
  Begin(second);
  AddKeyframe({second, 0});
  manager_->Step();
  EXPECT_FALSE(uplink_.stored[second].back().points_follow);
  // The store is replaced by a newer one.
  uplink_.capabilities.points_follow = true;
  uplink_.Break(absl::UnavailableError("restarted"));
  manager_->Step();
  AddKeyframe({second, 1});
  manager_->Step();
  EXPECT_TRUE(uplink_.stored[second].back().points_follow);
}

TEST_F(StoreLinkTest, TellsExactPlacesWhenAsked) {
  AddKeyframe({kOwn, 0});
  MapPoint point;
  point.id = {kOwn, 0};
  point.reference = {kOwn, 0};
  point.position_in_map = {0, 0, 10};
  map_->Write([&](Map& map) { map.AddPoint(point); });
  manager_->Step();
  // No keyframe sees the point, so that its move changes no picture.
  map_->Write([&](Map& map) { map.SetPosition(point.id, {0, 0, 11}); });
  manager_->Step();
  ASSERT_EQ(uplink_.stored[kOwn].size(), 1u);
  uplink_.AskForExactPlaces();
  manager_->Step();
  ASSERT_EQ(uplink_.stored[kOwn].size(), 2u);
  ASSERT_EQ(uplink_.stored[kOwn].back().light_points.size(), 1u);
  EXPECT_EQ(uplink_.stored[kOwn].back().light_points[0].position_in_local.z(), 11);
}

TEST_F(StoreLinkTest, ALocalMapThatEndedIsReadNoMoreOnceAllOfItIsInBatches) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  uplink_.acknowledge = false;
  AddKeyframe({kOwn, 1});
  const LocalMapId second{2};
  Begin(second);
  EXPECT_TRUE(manager_->Reads(kOwn));
  manager_->Step();
  EXPECT_FALSE(manager_->Reads(kOwn));
  EXPECT_TRUE(manager_->Reads(second));
  // The ended map is not needed any more, though the store has not acknowledged the rest of it.
  maps_.front().reset();
  uplink_.Break(absl::UnavailableError("cut"));
  uplink_.acknowledge = true;
  AddKeyframe({second, 0});
  manager_->Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  size_t keyframes = 0;
  for (const auto& batch : uplink_.stored[kOwn]) keyframes += batch.full_keyframes.size();
  EXPECT_EQ(keyframes, 2U);
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
}

// A point with an impossible position would make the store refuse the whole batch.
TEST_F(StoreLinkTest, ABadItemIsLeftOutAndCounted) {
  AddKeyframe({kOwn, 0});
  MapPoint point;
  point.reference = {kOwn, 0};
  for (uint32_t i = 0; i < 3; ++i) {
    point.id = {kOwn, i};
    point.position_in_map = {0, 0, i == 1 ? std::numeric_limits<double>::quiet_NaN() : 10};
    map_->Write([&](Map& map) { map.AddPoint(point); });
  }
  manager_->Step();
  ASSERT_EQ(uplink_.stored[kOwn].size(), 1U);
  std::vector<MapPointId> told;
  for (const FullMapPoint& full : uplink_.stored[kOwn][0].full_points) told.push_back(full.id);
  EXPECT_EQ(told, (std::vector<MapPointId>{{kOwn, 0}, {kOwn, 2}}));
  EXPECT_EQ(manager_->upload().refused_items, 1U);
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  // The count outlives the local map.
  Begin({2});
  manager_->Step();
  EXPECT_FALSE(manager_->Reads(kOwn));
  EXPECT_EQ(manager_->upload().refused_items, 1U);
}

TEST_F(StoreLinkTest, ABatchThatIsRefusedForGoodBeginsANewLocalMap) {
  AddKeyframe({kOwn, 0});
  manager_->Step();
  uplink_.acknowledge = false;
  uplink_.accept = false;
  AddKeyframe({kOwn, 1});
  manager_->Step();
  // Which batch was refused is certain once the next session begins with it again.
  uplink_.Break(absl::InvalidArgumentError("x_px of keypoint 7 is nan"));
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  manager_->Step();
  EXPECT_TRUE(manager_->NeedsNewLocalMap());
  EXPECT_EQ(manager_->upload().lost_local_maps, 1);
  EXPECT_NE(manager_->upload().loss.message().find("keypoint 7"), std::string::npos);
  uplink_.accept = true;
  uplink_.acknowledge = true;
  const LocalMapId second{2};
  Begin(second);
  AddKeyframe({second, 0});
  manager_->Step();
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(uplink_.stored[second].at(0).full_keyframes.size(), 1U);
  EXPECT_EQ(uplink_.stored[kOwn].size(), 1U);
}

// The store took the first batch; what it refused came later.
TEST_F(StoreLinkTest, ABatchThatTheStoreTookIsNotSuspected) {
  AddKeyframe({kOwn, 0});
  uplink_.acknowledge = false;
  manager_->Step();
  uplink_.Break(absl::InvalidArgumentError("something of another batch"));
  uplink_.acknowledge = true;
  AddKeyframe({kOwn, 1});
  manager_->Step();
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
}

TEST_F(StoreLinkTest, AStoreThatRefusesTheSessionItselfIsNotAskedAgain) {
  uplink_.refusal = absl::InvalidArgumentError("name of the mission");
  manager_->Step();
  manager_->Step();
  EXPECT_EQ(uplink_.requests.size(), 1U);
  EXPECT_TRUE(absl::IsInvalidArgument(manager_->Finish(absl::Seconds(1))));
}

TEST_F(StoreLinkTest, ThreadedModeSendsAndStops) {
  AddKeyframe({kOwn, 0});
  manager_->Start();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(10)).ok());
  manager_.reset();
  EXPECT_EQ(uplink_.stored[kOwn].size(), 2U);
}

// A robot tracks its last frame and ends while the link's thread is about to take batches.
TEST_F(StoreLinkTest, TheLastBatchHasFramesThatComeWhileItIsTaken) {
  AddKeyframe({kOwn, 0});
  bool has_ended = false;
  uplink_.when_asked = [&] {
    if (std::exchange(has_ended, true)) return;
    manager_->AddTrackedFrame({7, {kOwn, 0}, Rigid3d::Identity()});
    manager_->EndLocalMap(kOwn);
  };
  manager_->Step();
  EXPECT_TRUE(has_ended);
  size_t frames = 0;
  for (const auto& batch : uplink_.stored[kOwn]) frames += batch.tracked_frames.size();
  EXPECT_EQ(frames, 1U);
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
}

}  // namespace
}  // namespace corbslam::client_agent
