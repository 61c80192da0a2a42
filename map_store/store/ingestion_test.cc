// Tests what agents send: sessions, numbers, rights, nonsense, and references in any order.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "map_store/store/map_store.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kMapA = {0xa};
constexpr LocalMapId kMapB = {0xb};
constexpr KeyframeId KfA(uint32_t index) { return {kMapA, index}; }
constexpr MapPointId PtA(uint32_t index) { return {kMapA, index}; }
constexpr MapPointId PtB(uint32_t index) { return {kMapB, index}; }

std::shared_ptr<const Camera> MakeCamera() {
  auto camera = std::make_shared<Camera>();
  *camera = {500, 500, 320, 240, 640, 480, 0.1, 4};
  return camera;
}

Rigid3d PoseAt(double x) { return {Eigen::Quaterniond::Identity(), {-x, 0, 0}}; }

FullKeyframe MakeKeyframe(KeyframeId id, double x, KeyframeId parent = {}) {
  Features features;
  features.keypoints.resize(4);
  features.descriptors.resize(4);
  // As it comes from the wire, the payload has no camera, which its index names.
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = id;
  payload->timestamp_ns = static_cast<int64_t>(id.index) * 100;
  payload->features = features;
  return {payload, PoseAt(x), parent};
}

FullMapPoint MakePoint(MapPointId id, KeyframeId reference) {
  FullMapPoint point;
  point.id = id;
  point.position_in_local = {0, 0, 5};
  point.reference = reference;
  return point;
}

class FailingJournal : public InMemoryJournal {
 public:
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override {
    if (fails) return absl::ResourceExhaustedError("disk full");
    return InMemoryJournal::Append(mission, record);
  }
  absl::Status Sync(absl::string_view, Position) override {
    return sync_fails ? absl::UnavailableError("disk gone") : absl::OkStatus();
  }
  bool fails = false;
  bool sync_fails = false;
};

class IngestionTest : public ::testing::Test {
 protected:
  static MapStoreOptions Options() {
    MapStoreOptions options;
    options.deterministic = true;
    options.max_parked_references = 3;
    return options;
  }

  uint64_t Open(const std::string& agent, const std::vector<LocalMapId>& local_maps = {}) {
    SessionRequest request;
    request.mission = "m";
    request.agent = agent;
    request.local_maps = local_maps;
    const auto opened = store_.OpenSession(request);
    EXPECT_TRUE(opened.ok()) << opened.status();
    last_grant_ = opened->grant;
    return opened->session_id;
  }

  // Returns a batch of two keyframes that both see one point.
  MapUpdateBatch First(LocalMapId map = kMapA) {
    MapUpdateBatch batch;
    batch.local_map = map;
    batch.number = 1;
    batch.cameras = {MakeCamera()};
    batch.full_keyframes = {MakeKeyframe({map, 0}, 0), MakeKeyframe({map, 1}, 1, {map, 0})};
    batch.full_points = {MakePoint({map, 0}, {map, 0})};
    batch.observations = {Add({map, 0}, {map, 0}, 0), Add({map, 0}, {map, 1}, 0)};
    return batch;
  }
  static MapUpdateBatch Next(uint64_t number, LocalMapId map = kMapA) {
    MapUpdateBatch batch;
    batch.local_map = map;
    batch.number = number;
    return batch;
  }
  static ObservationChange Add(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
    return {ObservationChange::Kind::kAdded, point, keyframe, keypoint};
  }
  size_t Observed(KeyframeId id) { return store_.GetKeyframe("m", id)->observed_points; }
  LocalMapInfo MapInfo(LocalMapId id = kMapA) { return *store_.GetLocalMap("m", id); }

  FailingJournal* journal_ = new FailingJournal();
  MapStore store_{Options(), nullptr, std::unique_ptr<Journal>(journal_), nullptr};
  SessionGrant last_grant_;
};

TEST_F(IngestionTest, AppliesABatchOnceHoweverOftenItComes) {
  const uint64_t a = Open("a");
  EXPECT_EQ(store_.Apply(a, First())->number, 1u);
  EXPECT_EQ(store_.Apply(a, Next(2))->number, 2u);
  // Late duplicates say how far everything is stored.
  EXPECT_EQ(store_.Apply(a, First())->number, 2u);
  EXPECT_EQ(MapInfo().keyframes, 2u);
  EXPECT_EQ(store_.GetStatistics("m")->full_keyframes.count, 2u);
  // Known items in a new batch are not taken again either.
  MapUpdateBatch again = First();
  again.number = 3;
  again.full_keyframes[1].camera_from_local = PoseAt(50);
  ASSERT_TRUE(store_.Apply(a, again).ok());
  EXPECT_EQ(MapInfo().keyframes, 2u);
  EXPECT_EQ(store_.GetKeyframe("m", KfA(1))->camera_from_local.translation.x(), -1);
}

TEST_F(IngestionTest, NamesTheExpectedNumberWhereSomeAreMissing) {
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  const auto status = store_.Apply(a, Next(5)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("expected 2"));
}

TEST_F(IngestionTest, ResumesWhereItsLocalMapsStand) {
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  const uint64_t again = Open("a", {kMapA, {0xc}});
  ASSERT_EQ(last_grant_.acknowledged.size(), 2u);
  EXPECT_EQ(last_grant_.acknowledged[0].number, 1u);
  EXPECT_EQ(last_grant_.acknowledged[1].number, 0u);
  // The older session is fenced, whatever it tries.
  EXPECT_EQ(store_.Apply(a, Next(2)).status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(store_.NextShared(a, 1000).status().code(), absl::StatusCode::kAborted);
  EXPECT_TRUE(store_.Apply(again, Next(2)).ok());
  store_.CloseSession(a);
  EXPECT_TRUE(store_.Apply(again, Next(3)).ok()) << "the old one's end is not the new one's";
}

// Of two robots of one name the second is told so, and the first goes on.
TEST_F(IngestionTest, AnotherProcessDoesNotTakeASessionOver) {
  SessionRequest first{"m", "a", 0, {}, /*instance=*/1};
  first.peer = "ipv4:10.0.0.5:4711";
  const uint64_t a = store_.OpenSession(first)->session_id;
  SessionRequest second{"m", "a", 0, {}, /*instance=*/2};
  const absl::Status refused = store_.OpenSession(second).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kAlreadyExists);
  for (const char* part : {"agent a of mission m", "since 20", "ipv4:10.0.0.5:4711", "--agent",
                           "--take-over", "within a minute"}) {
    EXPECT_THAT(std::string(refused.message()), HasSubstr(part));
  }
  EXPECT_TRUE(store_.Apply(a, First()).ok());
  // Another name may be taken, and so may the same one once it is free.
  second.agent = "b";
  EXPECT_TRUE(store_.OpenSession(second).ok());
  second.agent = "a";
  store_.CloseSession(a);
  EXPECT_TRUE(store_.OpenSession(second).ok());
}

TEST_F(IngestionTest, TheSameProcessAndOneThatIsToldToTakeASessionOver) {
  const SessionRequest first{"m", "a", 0, {}, /*instance=*/1};
  const uint64_t a = store_.OpenSession(first)->session_id;
  // The agent's link broke, and the store has not noticed.
  const uint64_t again = store_.OpenSession(first)->session_id;
  EXPECT_EQ(store_.Apply(a, First()).status().code(), absl::StatusCode::kAborted);
  SessionRequest second{"m", "a", 0, {}, /*instance=*/2};
  EXPECT_FALSE(store_.OpenSession(second).ok());
  second.take_over = true;
  ASSERT_TRUE(store_.OpenSession(second).ok());
  EXPECT_EQ(store_.Apply(again, First()).status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(store_.OpenSession(first).status().code(), absl::StatusCode::kAlreadyExists);
  // An agent that says nothing of processes may always take over: it is older than this rule.
  EXPECT_TRUE(store_.OpenSession({"m", "a", 0, {}}).ok());
}

TEST_F(IngestionTest, FencingWakesTheOldSession) {
  const uint64_t a = Open("a");
  int calls = 0;
  store_.SetSharedListener(a, [&calls] { ++calls; });
  Open("a");
  EXPECT_EQ(calls, 1);
}

TEST_F(IngestionTest, WritesOnlyItsOwnLocalMaps) {
  const uint64_t a = Open("a");
  const uint64_t b = Open("b");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  EXPECT_EQ(store_.Apply(b, Next(2)).status().code(), absl::StatusCode::kPermissionDenied);
  MapUpdateBatch batch = First(kMapB);
  batch.light_points.push_back({PtA(0), {0, 0, 9}});
  EXPECT_EQ(store_.Apply(b, batch).status().code(), absl::StatusCode::kPermissionDenied);
  batch.light_points.clear();
  batch.removed_keyframes.push_back({KfA(0), {}, {}});
  EXPECT_EQ(store_.Apply(b, batch).status().code(), absl::StatusCode::kPermissionDenied);
  SessionRequest request;
  request.mission = "m";
  request.agent = "c";
  request.local_maps = {kMapA};
  EXPECT_EQ(store_.OpenSession(request).status().code(), absl::StatusCode::kPermissionDenied);
  // The connection's other work is unharmed.
  EXPECT_TRUE(store_.Apply(b, First(kMapB)).ok());
}

TEST_F(IngestionTest, RefusesNonsenseAsAWhole) {
  const uint64_t a = Open("a");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<MapUpdateBatch> bad(10, First());
  bad[0].full_keyframes[1].camera_from_local.translation.x() = nan;
  bad[1].full_keyframes[1].camera_from_local.rotation.coeffs().setZero();
  bad[2].full_points[0].position_in_local.y() = nan;
  bad[3].observations[1].keypoint = 4;
  bad[4].cameras.clear();
  bad[5].full_keyframes[0].payload = nullptr;
  bad[6].tracked_frames.push_back({5, {}, {}});
  bad[7].loop_edges.push_back({KfA(0), KfA(1), {nan, {}, {}}});
  bad[8].number = 0;
  bad[9].replacements.push_back({PtA(0), PtA(0)});
  for (size_t i = 0; i < bad.size(); ++i) {
    EXPECT_EQ(store_.Apply(a, bad[i]).status().code(), absl::StatusCode::kInvalidArgument) << i;
  }
  EXPECT_EQ(store_.GetMission("m")->local_maps, 0u) << "nothing was stored";
  EXPECT_TRUE(store_.Apply(a, First()).ok());
}

TEST_F(IngestionTest, NothingIsAcknowledgedThatTheJournalHasNot) {
  const uint64_t a = Open("a");
  journal_->fails = true;
  EXPECT_EQ(store_.Apply(a, First()).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(store_.GetMission("m")->local_maps, 0u);
  journal_->fails = false;
  EXPECT_TRUE(store_.Apply(a, First()).ok());
}

// The batch is in memory then, but that is nothing to rely on: the agent sends it again.
TEST_F(IngestionTest, NothingIsAcknowledgedBeforeItIsSynced) {
  const uint64_t a = Open("a");
  journal_->sync_fails = true;
  EXPECT_EQ(store_.Apply(a, First()).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(store_.Apply(a, First()).status().code(), absl::StatusCode::kUnavailable);
  journal_->sync_fails = false;
  EXPECT_EQ(store_.Apply(a, First())->number, 1u);
  EXPECT_EQ(store_.GetMission("m")->keyframes, 2u);
}

// What a grant acknowledges is as good as any other acknowledgement.
TEST_F(IngestionTest, NoGrantAcknowledgesWhatIsNotSynced) {
  const uint64_t a = Open("a");
  journal_->sync_fails = true;
  ASSERT_FALSE(store_.Apply(a, First()).ok());
  SessionRequest request;
  request.mission = "m";
  request.agent = "a";
  request.local_maps = {kMapA};
  EXPECT_EQ(store_.OpenSession(request).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_FALSE(store_.ListAgents("m", {})->items[0].connected);
  journal_->sync_fails = false;
  Open("a", {kMapA});
  ASSERT_EQ(last_grant_.acknowledged.size(), 1u);
  EXPECT_EQ(last_grant_.acknowledged[0].number, 1u);
}

// Each point is found in one step again once somebody has gone all the way.
TEST_F(IngestionTest, LongChainsOfReplacementsCostNoTime) {
  const uint64_t a = Open("a");
  constexpr uint32_t kLength = 50000;
  MapUpdateBatch batch = First();
  for (uint32_t i = 1; i < kLength; ++i) batch.replacements.push_back({PtA(i), PtA(i + 1)});
  ASSERT_TRUE(store_.Apply(a, batch).ok());
  MapUpdateBatch seen = Next(2);
  for (uint32_t i = 0; i < kLength; ++i) seen.observations.push_back(Add(PtA(1), KfA(0), 2));
  ASSERT_TRUE(store_.Apply(a, seen).ok());
  EXPECT_EQ(MapInfo().map_points, 1u);
}

TEST_F(IngestionTest, ParksWhatComesBeforeItsPointWithinALimit) {
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  MapUpdateBatch early = Next(2);
  early.observations = {Add(PtA(1), KfA(0), 1), Add(PtA(1), KfA(2), 1)};
  ASSERT_TRUE(store_.Apply(a, early).ok());
  EXPECT_EQ(MapInfo().parked_references, 2u);
  EXPECT_EQ(Observed(KfA(0)), 1u);

  MapUpdateBatch many = Next(3);
  many.observations = {Add(PtA(7), KfA(0), 1), Add(PtA(8), KfA(0), 2)};
  EXPECT_EQ(store_.Apply(a, many).status().code(), absl::StatusCode::kResourceExhausted);

  MapUpdateBatch late = Next(3);
  late.full_points = {MakePoint(PtA(1), KfA(0))};
  late.full_keyframes = {MakeKeyframe(KfA(2), 2, KfA(1))};
  ASSERT_TRUE(store_.Apply(a, late).ok());
  EXPECT_EQ(MapInfo().parked_references, 0u);
  EXPECT_EQ(Observed(KfA(0)), 2u);
  EXPECT_EQ(Observed(KfA(2)), 1u);
}

TEST_F(IngestionTest, RemovedIdsNeverComeBack) {
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  MapUpdateBatch removal = Next(2);
  removal.removed_points = {PtA(0), PtA(5)};
  removal.removed_keyframes = {{KfA(1), KfA(0), PoseAt(0)}, {KfA(6), KfA(0), PoseAt(0)}};
  ASSERT_TRUE(store_.Apply(a, removal).ok());
  MapUpdateBatch again = First();
  again.number = 3;
  again.full_points.push_back(MakePoint(PtA(5), KfA(0)));
  again.full_keyframes.push_back(MakeKeyframe(KfA(6), 6));
  ASSERT_TRUE(store_.Apply(a, again).ok());
  EXPECT_EQ(MapInfo().keyframes, 1u);
  EXPECT_EQ(MapInfo().map_points, 0u);
  EXPECT_EQ(MapInfo().parked_references, 0u) << "nothing waits for what is gone";
}

TEST_F(IngestionTest, FramesOfARemovedKeyframeFollowItsParent) {
  const uint64_t a = Open("a");
  MapUpdateBatch batch = First();
  batch.full_keyframes.push_back(MakeKeyframe(KfA(2), 2, KfA(1)));
  batch.tracked_frames = {{10, KfA(0), PoseAt(0)}, {20, KfA(1), PoseAt(0)}, {40, KfA(2), {}}};
  batch.lost_frames_ns = {30};
  ASSERT_TRUE(store_.Apply(a, batch).ok());
  MapUpdateBatch removal = Next(2);
  // parent_from_removed: the removed camera stood at x = 1 of its parent's camera.
  removal.removed_keyframes = {{KfA(1), KfA(0), PoseAt(-1)}, {KfA(2), KfA(1), PoseAt(-1)}};
  removal.light_keyframes = {{KfA(0), PoseAt(10), {}}};
  ASSERT_TRUE(store_.Apply(a, removal).ok());
  const auto trajectory = store_.GetTrajectory("m", "a", TrajectoryFrame::kLocal);
  ASSERT_TRUE(trajectory.ok());
  const std::vector<StoredPose>& poses = trajectory->at(0).poses;
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_NEAR(poses[0].frame_from_camera.translation.x(), 10, 1e-12);
  EXPECT_NEAR(poses[1].frame_from_camera.translation.x(), 11, 1e-12);
  EXPECT_NEAR(poses[2].frame_from_camera.translation.x(), 12, 1e-12);
  EXPECT_FALSE(poses[1].after_gap);
  EXPECT_TRUE(poses[2].after_gap);
}

RecordedCamera MakeRecorded() {
  RecordedCamera recorded;
  recorded.lens = {500, 500, 320, 240, {}};
  recorded.camera_from_recorded.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  // The camera sits 2 m ahead on the body.
  recorded.body_from_recorded = Rigid3d{Eigen::Quaterniond::Identity(), {0, 0, 2}};
  return recorded;
}

TEST_F(IngestionTest, PosesAreOfTheFrameThatIsWanted) {
  const uint64_t a = Open("a");
  MapUpdateBatch batch = First();
  batch.recorded_cameras = {MakeRecorded()};
  batch.tracked_frames = {{10, KfA(1), PoseAt(0)}};
  ASSERT_TRUE(store_.Apply(a, batch).ok());
  const auto pose = [&](PosesOf poses_of) {
    return store_.GetTrajectory("m", "a", TrajectoryFrame::kLocal, false, poses_of)
        ->at(0)
        .poses.at(0)
        .frame_from_camera;
  };
  const Rigid3d rectified = pose(PosesOf::kRectifiedCamera);
  EXPECT_LT((rectified.translation - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(RotationAngle(rectified.rotation), 0, 1e-12);
  const Rigid3d camera = pose(PosesOf::kRecordedCamera);
  EXPECT_LT((camera.translation - rectified.translation).norm(), 1e-12);
  EXPECT_NEAR(RotationAngle(camera.rotation), 0.1, 1e-9);
  // The body is 2 m behind the recorded camera, along the camera's own axis.
  const Rigid3d body = pose(PosesOf::kBody);
  EXPECT_LT((body.translation - (camera * Eigen::Vector3d(0, 0, -2))).norm(), 1e-12);
  EXPECT_NEAR(RotationAngle(body.rotation), 0.1, 1e-9);
}

TEST_F(IngestionTest, WithoutARecordedCameraTheCameraIsIt) {
  const uint64_t a = Open("a");
  MapUpdateBatch batch = First();
  batch.tracked_frames = {{10, KfA(1), PoseAt(0)}};
  ASSERT_TRUE(store_.Apply(a, batch).ok());
  const auto camera = store_.GetTrajectory("m", "a", TrajectoryFrame::kLocal);
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_NEAR(RotationAngle(camera->at(0).poses.at(0).frame_from_camera.rotation), 0, 1e-12);
  const absl::Status body =
      store_.GetTrajectory("m", "a", TrajectoryFrame::kLocal, false, PosesOf::kBody).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(body)) << body;
  EXPECT_THAT(std::string(body.message()), HasSubstr("agent a, local map 000000000000000a"));
}

TEST_F(IngestionTest, RecordedCamerasComeWithTheirCamerasAndStay) {
  const uint64_t a = Open("a");
  MapUpdateBatch batch = First();
  batch.recorded_cameras = {MakeRecorded(), MakeRecorded()};
  EXPECT_TRUE(absl::IsInvalidArgument(store_.Apply(a, batch).status()));
  batch.recorded_cameras = {MakeRecorded()};
  batch.recorded_cameras[0].lens.fx_px = -1;
  EXPECT_TRUE(absl::IsInvalidArgument(store_.Apply(a, batch).status()));
  batch.recorded_cameras = {MakeRecorded()};
  ASSERT_TRUE(store_.Apply(a, batch).ok());
  MapUpdateBatch again = Next(2);
  again.cameras = batch.cameras;
  again.recorded_cameras = batch.recorded_cameras;
  EXPECT_TRUE(store_.Apply(a, again).ok());
  again.number = 3;
  again.recorded_cameras[0].body_from_recorded.reset();
  const absl::Status differs = store_.Apply(a, again).status();
  EXPECT_TRUE(absl::IsInvalidArgument(differs));
  EXPECT_THAT(std::string(differs.message()), HasSubstr("recorded camera 0 differs"));
}

TEST_F(IngestionTest, ObservationChangesReplaceWhatTheOwnerSaidBefore) {
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  MapUpdateBatch change = Next(2);
  change.full_points = {MakePoint(PtA(1), KfA(0))};
  change.observations = {{ObservationChange::Kind::kRemoved, PtA(0), KfA(1), 0},
                         Add(PtA(1), KfA(1), 0),
                         Add(PtA(1), KfA(0), 2)};
  ASSERT_TRUE(store_.Apply(a, change).ok());
  EXPECT_EQ(Observed(KfA(0)), 2u);
  EXPECT_EQ(Observed(KfA(1)), 1u);
  MapUpdateBatch replace = Next(3);
  replace.replacements = {{PtA(0), PtA(1)}};
  ASSERT_TRUE(store_.Apply(a, replace).ok());
  EXPECT_EQ(MapInfo().map_points, 1u);
  EXPECT_EQ(Observed(KfA(0)), 1u);
}

TEST_F(IngestionTest, ForeignReferencesWaitForTheOther) {
  const uint64_t a = Open("a");
  MapUpdateBatch batch = First();
  // The point is replaced by one of a robot that the store has never heard of.
  batch.replacements = {{PtA(0), PtB(0)}};
  batch.observations.push_back(Add(PtB(1), KfA(0), 2));
  ASSERT_TRUE(store_.Apply(a, batch).ok());
  EXPECT_EQ(Observed(KfA(0)), 0u);
  const uint64_t b = Open("b");
  ASSERT_TRUE(store_.Apply(b, First(kMapB)).ok());
  // The other robot's point is there now, but in another island: it counts once the two are fused.
  EXPECT_EQ(Observed(KfA(0)), 0u);
  // The other robot says the reverse: the point stays, and the store doesn't go in a circle.
  MapUpdateBatch mutual = Next(2, kMapB);
  mutual.replacements = {{PtB(0), PtA(0)}};
  ASSERT_TRUE(store_.Apply(b, mutual).ok());
  EXPECT_EQ(MapInfo(kMapB).map_points, 1u);
}

TEST_F(IngestionTest, NamesMustBeNames) {
  SessionRequest request;
  for (const std::string& bad : {std::string(), std::string("a/b"), std::string(129, 'a')}) {
    request.mission = "m";
    request.agent = bad;
    EXPECT_EQ(store_.OpenSession(request).status().code(), absl::StatusCode::kInvalidArgument);
    request.mission = bad;
    request.agent = "a";
    EXPECT_EQ(store_.OpenSession(request).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST_F(IngestionTest, LookUpsOfWhatIsNotThereAndPages) {
  EXPECT_EQ(store_.GetMission("m").status().code(), absl::StatusCode::kNotFound);
  const uint64_t a = Open("a");
  EXPECT_TRUE(store_.GlobalMapView("m")->empty()) << "asked before there is a map";
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  EXPECT_EQ(store_.GetKeyframe("m", KfA(9)).status().code(), absl::StatusCode::kNotFound);
  const auto first = store_.ListKeyframes("m", kMapA, {1, ""});
  ASSERT_EQ(first->items.size(), 1u);
  const auto second = store_.ListKeyframes("m", kMapA, {1, first->next_page_token});
  EXPECT_EQ(second->items.at(0).id, KfA(1));
  EXPECT_TRUE(second->next_page_token.empty());
  EXPECT_EQ(store_.ListKeyframes("m", kMapA, {1, "x"}).status().code(),
            absl::StatusCode::kInvalidArgument);
  ASSERT_TRUE(store_.DeleteMission("m").ok());
  EXPECT_EQ(store_.Apply(a, Next(2)).status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(store_.GetMission("m").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(IngestionTest, WatchersSeeWhatChanged) {
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_.Apply(a, First()).ok());
  int calls = 0;
  const uint64_t token = *store_.AddMapListener("m", [&calls] { ++calls; });
  constexpr size_t kAll = 1000000;
  MapWatcher watcher(0, false);
  const uint64_t version = (*store_.NextChanges("m", kAll, watcher))->version;
  EXPECT_FALSE(store_.NextChanges("m", kAll, watcher)->has_value());
  MapWatcher of_a_store_before(version + 5, false);
  EXPECT_EQ((*store_.NextChanges("m", kAll, of_a_store_before))->islands.size(), 1u);
  MapWatcher comes_back(version, false);
  EXPECT_FALSE(store_.NextChanges("m", kAll, comes_back)->has_value());
  ASSERT_TRUE(store_.Apply(a, Next(2)).ok());
  EXPECT_EQ(calls, 1);
  EXPECT_EQ((*store_.NextChanges("m", kAll, watcher))->islands.size(), 1u);
  store_.RemoveMapListener("m", token);
  ASSERT_TRUE(store_.Apply(a, Next(3)).ok());
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace corbslam::map_store
