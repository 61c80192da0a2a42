// A replica fed with batches alone must stay equal to the observed map, whatever happens to it.
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "client_agent/upload/outbox.h"
#include "client_agent/upload/testing/recorded_map.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

void MoveWithFollowers(KeyframeId id, const Rigid3d& camera_from_map, Map& replica) {
  const Rigid3d now_from_before =
      camera_from_map.Inverse() * replica.FindKeyframe(id)->camera_from_map;
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> moved;
  for (const auto& [point_id, point] : replica.points()) {
    if (point.reference != id) continue;
    moved.emplace_back(point_id, now_from_before * point.position_in_map);
  }
  for (const auto& [point_id, position] : moved) replica.SetPosition(point_id, position);
  replica.SetPose(id, camera_from_map);
}

struct Store {
  // One of an older version moves no points with their keyframes.
  bool is_old = false;
  // The root is never removed: then no parent makes a cycle with what was there before.
  bool root_stays = false;
};

// Does what a map store does with a batch.
void Apply(const MapUpdateBatch& batch, const Store& store, Map& replica) {
  std::vector<std::pair<KeyframeId, KeyframeId>> parked;
  for (const FullKeyframe& full : batch.full_keyframes) {
    Keyframe keyframe;
    keyframe.payload = full.payload;
    keyframe.camera_from_map = full.camera_from_local;
    keyframe.parent = full.parent;
    EXPECT_TRUE(replica.AddKeyframe(keyframe));
  }
  for (const FullMapPoint& full : batch.full_points) {
    MapPoint point;
    point.id = full.id;
    point.position_in_map = full.position_in_local;
    point.reference = full.reference;
    EXPECT_NE(replica.FindKeyframe(full.reference), nullptr);
    EXPECT_TRUE(replica.AddPoint(point));
  }
  for (const LightKeyframe& light : batch.light_keyframes) {
    if (batch.points_follow && !store.is_old) {
      MoveWithFollowers(light.id, light.camera_from_local, replica);
    } else {
      replica.SetPose(light.id, light.camera_from_local);
    }
    if (light.parent.IsValid() && !replica.SetParent(light.id, light.parent)) {
      EXPECT_FALSE(store.root_stays) << ToString(light.id) << " on " << ToString(light.parent);
      parked.emplace_back(light.id, light.parent);
    }
  }
  for (const LightMapPoint& light : batch.light_points) {
    replica.SetPosition(light.id, light.position_in_local);
  }
  for (const PointReplacement& r : batch.replacements) {
    EXPECT_TRUE(replica.ReplacePoint(r.replaced, r.survivor));
  }
  for (const ObservationChange& change : batch.observations) {
    const bool done = change.kind == ObservationChange::Kind::kAdded
                          ? replica.AddObservation(change.point, change.keyframe, change.keypoint)
                          : replica.RemoveObservation(change.point, change.keyframe);
    EXPECT_TRUE(done) << ToString(change.point) << " in " << ToString(change.keyframe);
  }
  for (const MapPointId& id : batch.removed_points) EXPECT_TRUE(replica.RemovePoint(id));
  for (const KeyframeRemoval& removal : batch.removed_keyframes) replica.RemoveKeyframe(removal.id);
  // These would have made a cycle with what was there before.
  for (const auto& [id, parent] : parked) EXPECT_TRUE(replica.SetParent(id, parent));
}

class Scenario {
 public:
  explicit Scenario(uint32_t seed, const RecorderOptions& options = {.hold_newest = 0})
      : random_(seed),
        options_(options),
        recorder_(std::make_unique<UpdateRecorder>(kOwn, options)) {
    // Where trees are the same on both sides whenever a batch has gone up, it may be removed.
    store_.root_stays =
        options.hold_newest > 0 || options.limits.light_keyframes < BatchLimits().light_keyframes;
    map_.SetObserver(recorder_.get());
    // A few foreign points that both sides hold, as after sharing.
    AddForeignPoints(map_);
    AddForeignPoints(replica_);
  }

  void Step() {
    switch (random_() % 10) {
      case 0:
      case 1:
        return AddKeyframe();
      case 2:
      case 3:
        return AddPoint();
      case 4:
      case 5:
      case 6:
        map_.AddObservation(AnyPoint(), AnyKeyframe(),
                            static_cast<uint32_t>(random_()) % kKeypoints);
        return;
      case 7:
        return Move();
      case 8:
        return Remove();
      case 9:
        if (const MapPointId replaced = AnyPoint(); replaced.local_map == kOwn) {
          map_.ReplacePoint(replaced, AnyPoint());
        }
        return;
    }
  }

  MapUpdateBatch Flush(size_t max_keyframes) {
    const MapUpdateBatch batch = recorder_->TakeBatch(map_, max_keyframes);
    Apply(batch, store_, replica_);
    ApplyToSpooledMap(batch);
    return batch;
  }
  // The robot hears of it only when a session opens.
  void ReplaceStore(bool is_old) {
    store_.is_old = is_old;
    keeps_ = keeps_ && !is_old;
  }
  void OpenSession() { recorder_->SetPointsFollow(!store_.is_old); }
  // Takes a batch of so many bytes at most; returns what was told.
  MapUpdateBatch FlushBytes(double bytes) {
    const MapUpdateBatch batch = recorder_->TakeBatch(map_, BatchAllowance(1000, bytes, 1));
    Apply(batch, store_, replica_);
    ApplyToSpooledMap(batch);
    return batch;
  }
  UpdateCounts CountUntold() const { return recorder_->CountUntold(); }
  bool HasChanges() const { return recorder_->HasChanges(); }

  // The robot's process ends after the last batch, and the next one goes on with what was spooled.
  void Restart() {
    map_ = Map();
    spooled_map_.Fill([](const auto&) { return nullptr; }, map_);
    AddForeignPoints(map_);
    recorder_ = std::make_unique<UpdateRecorder>(kOwn, options_);
    recorder_->GoOnFrom(spooled_map_);
    map_.SetObserver(recorder_.get());
    next_keyframe_ = std::max(next_keyframe_, spooled_map_.next_keyframe());
    restarted_ = true;
  }

  // What is spooled is what the store has.
  void ExpectSpooledMapIsReplica() const {
    ASSERT_EQ(spooled_map_.keyframes().size(), replica_.keyframes().size());
    for (const auto& [id, keyframe] : replica_.keyframes()) {
      EXPECT_EQ(spooled_map_.observations().keyframes().at(id), keyframe.points) << ToString(id);
      const FullKeyframe& spooled = spooled_map_.keyframes().at(id);
      EXPECT_EQ(spooled.camera_from_local.translation, keyframe.camera_from_map.translation);
      EXPECT_LT(id.index, spooled_map_.next_keyframe());
    }
    for (const auto& [id, point] : replica_.points()) {
      if (id.local_map != kOwn) continue;
      ASSERT_TRUE(spooled_map_.points().contains(id)) << ToString(id);
      const Eigen::Vector3d& position = spooled_map_.points().at(id).position_in_local;
      EXPECT_LT((position - point.position_in_map).norm(), 1e-6 * (1 + position.norm()));
    }
  }

  // Expects that a snapshot tells the same.
  void ExpectSnapshotIsTheSame() const {
    SpooledMap again(kOwn);
    for (const MapUpdateBatch& batch : spooled_map_.ToBatches(3, 5)) {
      const absl::Status applied = again.Apply(batch);
      ASSERT_TRUE(applied.ok()) << applied;
    }
    EXPECT_EQ(again.observations().keyframes(), spooled_map_.observations().keyframes());
    EXPECT_EQ(again.next_keyframe(), spooled_map_.next_keyframe());
    EXPECT_EQ(again.next_point(), spooled_map_.next_point());
    EXPECT_EQ(again.newest_ns(), spooled_map_.newest_ns());
    EXPECT_EQ(again.points().size(), spooled_map_.points().size());
    for (const auto& [id, keyframe] : spooled_map_.keyframes()) {
      EXPECT_EQ(again.keyframes().at(id).parent, keyframe.parent);
    }
  }

  // Expects that points lie where nobody can tell the difference from the pictures.
  void ExpectPlacesThatLookTheSame() const {
    for (const auto& [id, point] : map_.points()) {
      const MapPoint* told = replica_.FindPoint(id);
      if (told == nullptr) continue;
      for (const auto& [keyframe_id, keypoint] : point.observations) {
        const Keyframe& keyframe = *map_.FindKeyframe(keyframe_id);
        const Eigen::Vector3d is = keyframe.camera_from_map * point.position_in_map;
        const Eigen::Vector3d believed = keyframe.camera_from_map * told->position_in_map;
        if (is == believed) continue;
        ASSERT_GT(is.z(), 0) << ToString(id);
        ASSERT_GT(believed.z(), 0) << ToString(id);
        const Eigen::Vector3d apart_px =
            500 * (is / is.z() - believed / believed.z());  // Of the focal length above.
        EXPECT_LE(apart_px.norm(), 0.5 + 1e-6) << ToString(id) << " in " << ToString(keyframe_id);
      }
    }
  }
  // Tells exactly; there is nothing left afterwards.
  void ExpectExactPlaces() {
    recorder_->AskForExactPlaces();
    for (int i = 0; i < 20 && HasChanges(); ++i) Flush(1000);
    EXPECT_FALSE(HasChanges());
    for (const auto& [id, point] : replica_.points()) {
      const Eigen::Vector3d& is = map_.FindPoint(id)->position_in_map;
      EXPECT_LT((point.position_in_map - is).norm(), 2e-6 * (1 + is.norm())) << ToString(id);
    }
  }

  void ExpectEqual() const {
    ASSERT_EQ(map_.keyframes().size(), replica_.keyframes().size());
    for (const auto& [id, keyframe] : map_.keyframes()) {
      const Keyframe& other = *replica_.FindKeyframe(id);
      for (size_t k = 0; k < other.points.size(); ++k) {
        const MapPointId seen = keyframe.points[NumberOf(other, k)];
        // Others' points come back when the store shares them again.
        if (restarted_ && !seen.IsValid() && other.points[k].local_map == kForeign) continue;
        EXPECT_EQ(seen, other.points[k]) << ToString(id);
      }
      EXPECT_EQ(keyframe.camera_from_map.translation, other.camera_from_map.translation);
      if (keyframe.parent.IsValid()) {
        EXPECT_EQ(keyframe.parent, other.parent);
      }
    }
    for (const auto& [id, point] : replica_.points()) {
      EXPECT_NE(map_.FindPoint(id), nullptr) << ToString(id);
    }
    for (const auto& [id, point] : map_.points()) {
      // What nobody sees need not be told.
      if (!IsSeenInReplica(point)) continue;
      EXPECT_NE(replica_.FindPoint(id), nullptr) << ToString(id);
    }
    ExpectPlacesThatLookTheSame();
  }

 private:
  static void AddForeignPoints(Map& map) {
    for (uint32_t i = 0; i < 10; ++i) {
      MapPoint point;
      point.id = {kForeign, i};
      map.AddPoint(point);
    }
  }
  void ApplyToSpooledMap(const MapUpdateBatch& batch) {
    if (!keeps_) return;
    const absl::Status applied = spooled_map_.Apply(batch);
    EXPECT_TRUE(applied.ok()) << applied;
  }
  // On the robot, of a keypoint at the store.
  static size_t NumberOf(const Keyframe& told, size_t keypoint) {
    return static_cast<size_t>(told.keypoints()[keypoint].x_px);
  }
  bool IsSeenInReplica(const MapPoint& point) const {
    for (const auto& [id, keypoint] : point.observations) {
      const Keyframe* told = replica_.FindKeyframe(id);
      for (size_t k = 0; told != nullptr && k < told->points.size(); ++k) {
        if (NumberOf(*told, k) == keypoint) return true;
      }
    }
    return false;
  }
  void AddKeyframe() {
    const KeyframeId parent = AnyKeyframe();
    map_.AddKeyframe(MakeKeyframe({kOwn, next_keyframe_++}, parent));
  }
  void AddPoint() {
    MapPoint point;
    point.id = {kOwn, next_point_++};
    point.reference = AnyKeyframe();
    point.position_in_map = {static_cast<double>(random_() % 100), 0, 500};
    map_.AddPoint(point);
    map_.AddObservation(point.id, point.reference, static_cast<uint32_t>(random_()) % kKeypoints);
  }
  void Move() {
    if (const MapPointId id = AnyPoint(); id.local_map == kOwn) {
      map_.SetPosition(id, map_.FindPoint(id)->position_in_map + AnyStep());
    }
    const KeyframeId id = AnyKeyframe();
    if (!id.IsValid()) return;
    Rigid3d pose = map_.FindKeyframe(id)->camera_from_map;
    pose.rotation =
        (Eigen::AngleAxisd(1e-3 * AnyStep().x(), Eigen::Vector3d::UnitY()) * pose.rotation)
            .normalized();
    pose.translation += AnyStep();
    map_.SetPose(id, pose);
    map_.SetParent(id, AnyKeyframe());
  }
  void Remove() {
    if (random_() % 4 == 0) {
      RemoveKeyframe(AnyKeyframe());
    } else if (const MapPointId id = AnyPoint(); id.local_map == kOwn) {
      map_.RemovePoint(id);
    } else {
      map_.RemoveObservation(AnyPoint(), AnyKeyframe());
    }
  }
  // Mapping never takes the root out. The map may, where trees are the same on both sides.
  void RemoveKeyframe(KeyframeId id) {
    const Keyframe* keyframe = map_.FindKeyframe(id);
    if (keyframe == nullptr || (store_.root_stays && !keyframe->parent.IsValid())) return;
    map_.RemoveKeyframe(id);
  }
  // Half of them too small to be seen from where the points are.
  Eigen::Vector3d AnyStep() {
    const double size_m = random_() % 2 == 0 ? 0.1 : 10;
    const auto any = [&] { return size_m * (static_cast<double>(random_() % 1000) / 500 - 1); };
    const double x = any();
    const double y = any();
    return {x, y, any()};
  }
  ptrdiff_t Below(size_t count) { return static_cast<ptrdiff_t>(random_() % count); }
  KeyframeId AnyKeyframe() {
    if (map_.keyframes().empty()) return {};
    return std::next(map_.keyframes().begin(), Below(map_.keyframes().size()))->first;
  }
  MapPointId AnyPoint() {
    return std::next(map_.points().begin(), Below(map_.points().size()))->first;
  }

  std::mt19937 random_;
  const RecorderOptions options_;
  std::unique_ptr<UpdateRecorder> recorder_;
  SpooledMap spooled_map_{kOwn};
  bool keeps_ = true;  // What an older store has is another map.
  bool restarted_ = false;
  Map map_;
  Map replica_;
  Store store_;
  uint32_t next_keyframe_ = 0;
  uint32_t next_point_ = 0;
};

TEST(UpdateRecorderTest, ReplicaFollowsRandomChanges) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 == 0) {
        scenario.Flush(1000);
        scenario.ExpectEqual();
        ASSERT_FALSE(scenario.HasChanges());
        ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
      }
    }
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, WhatIsKeptIsWhatTheStoreHas) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 15 != 0) continue;
      scenario.Flush(1000);
      scenario.ExpectSpooledMapIsReplica();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
    }
    scenario.Flush(1000);
    scenario.ExpectSnapshotIsTheSame();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

// What was not in a batch is lost, and all that follows is told as if there had been no restart.
TEST(UpdateRecorderTest, ANextProcessGoesOnWithWhatIsKept) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    RecorderOptions options;
    options.hold_newest = 0;
    // The root stays.
    options.limits.light_keyframes = BatchLimits().light_keyframes - 1;
    Scenario scenario(seed, options);
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 != 0) continue;
      scenario.Flush(1000);
      if (random() % 4 == 0) scenario.Restart();
      scenario.ExpectEqual();
      scenario.ExpectSpooledMapIsReplica();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
    }
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, BatchesLimitedInKeyframesConvergeToTheSame) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 10 == 0) scenario.Flush(1);
    }
    for (int i = 0; i < 200 && scenario.HasChanges(); ++i) scenario.Flush(2);
    EXPECT_FALSE(scenario.HasChanges());
    scenario.ExpectEqual();
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

constexpr BatchLimits kTinyLimits = {.full_points = 3,
                                     .light_keyframes = 2,
                                     .light_points = 2,
                                     .replacements = 1,
                                     .observations = 4,
                                     .removed_points = 1,
                                     .removed_keyframes = 1,
                                     .loop_edges = 1,
                                     .frames = 1,
                                     .pairs = 5};

// A backlog of any size goes up in batches that a store takes.
TEST(UpdateRecorderTest, BatchesLimitedInItemsConvergeToTheSame) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed, {.hold_newest = 0, .limits = kTinyLimits});
    std::mt19937 random(seed);
    const auto flush = [&] {
      const MapUpdateBatch batch = scenario.Flush(1);
      EXPECT_LE(batch.full_points.size(), kTinyLimits.full_points);
      EXPECT_LE(batch.light_keyframes.size(), kTinyLimits.light_keyframes);
      EXPECT_LE(batch.light_points.size(), kTinyLimits.light_points);
      EXPECT_LE(batch.replacements.size(), kTinyLimits.replacements);
      // One keyframe may lose and gain one at each of its keypoints.
      EXPECT_LT(batch.observations.size(), kTinyLimits.observations + 2 * kKeypoints);
      EXPECT_LE(batch.removed_points.size(), kTinyLimits.removed_points);
      EXPECT_LE(batch.removed_keyframes.size(), kTinyLimits.removed_keyframes);
    };
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 10 == 0) flush();
    }
    for (int i = 0; i < 2000 && scenario.HasChanges(); ++i) flush();
    EXPECT_FALSE(scenario.HasChanges());
    scenario.ExpectEqual();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, WhatIsHeldBackIsAllToldAtTheEnd) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed, {.hold_newest = 6});
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 != 0) continue;
      // Flushes as the link does, until there is nothing to tell.
      int batches = 0;
      while (!client_agent::IsEmpty(scenario.Flush(1 + random() % 10))) ASSERT_LT(++batches, 100);
    }
    scenario.ExpectExactPlaces();
    scenario.ExpectEqual();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, WhereFeaturesAreLeftOutTheOthersAreTold) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed, {.features = {seed % 2 == 0 ? 0u : 12u}, .hold_newest = seed % 4});
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 == 0) scenario.Flush(random() % 10);
    }
    scenario.ExpectExactPlaces();
    scenario.ExpectEqual();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, AStoreThatMovesNoPointsIsToldThemAll) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 == 0) scenario.Flush(1000);
      if (random() % 40 != 0) continue;
      scenario.ReplaceStore(random() % 2 == 0);
      // A batch that was made before the session says what the store can.
      scenario.Flush(1000);
      scenario.OpenSession();
      scenario.Flush(1000);
      scenario.ExpectEqual();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
    }
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

// Whatever is held back, and however long: no item is lost, none comes before what it refers to
// (Apply says so), points wait while a full keyframe does, and every batch tells something.
TEST(UpdateRecorderTest, BatchesLimitedInBytesConvergeToTheSame) {
  int all_batches = 0;
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    const auto flush = [&] {
      const MapUpdateBatch batch = scenario.FlushBytes(1 + static_cast<double>(random() % 4000));
      if (scenario.CountUntold()[static_cast<size_t>(UpdateKind::kKeyframes)] == 0) return batch;
      EXPECT_FALSE(batch.full_keyframes.empty());
      EXPECT_TRUE(batch.full_points.empty());
      EXPECT_TRUE(batch.light_points.empty());
      return batch;
    };
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 10 == 0) flush();
    }
    int batches = 0;
    for (; batches < 5000 && scenario.HasChanges(); ++batches) {
      // An empty one would close the local map.
      EXPECT_TRUE(!client_agent::IsEmpty(flush()) || !scenario.HasChanges());
    }
    all_batches += batches;
    EXPECT_FALSE(scenario.HasChanges());
    scenario.ExpectEqual();
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
  EXPECT_GT(all_batches, 80);
}

}  // namespace
}  // namespace corbslam::client_agent
