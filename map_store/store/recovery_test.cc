// Tests what a store reads back: all that was written, and nothing that no store would have
// written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "map_store/archive/archive.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/archive/value_fields.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/small_mission.h"
#include "slam/coding/testing/plausible_features.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::JournalBytes;
using testing::kSmallMapA;
using testing::kSmallMapB;

constexpr LocalMapId kNobody{3};

using Records = std::vector<JournalRecord>;

std::shared_ptr<JournalBytes> Write(const Records& records) {
  auto bytes = std::make_shared<JournalBytes>();
  ByteJournal journal(bytes);
  for (const JournalRecord& record : records) {
    EXPECT_TRUE(journal.Append(bytes->mission, record).ok());
  }
  return bytes;
}

absl::StatusOr<std::unique_ptr<MapStore>> Open(const std::shared_ptr<JournalBytes>& bytes,
                                               MapStoreOptions options = {}) {
  options.deterministic = true;
  auto store =
      std::make_unique<MapStore>(options, nullptr, std::make_unique<ByteJournal>(bytes), nullptr);
  const absl::Status recovered = testing::RecoverUndamaged(*store);
  if (!recovered.ok()) return recovered;
  return store;
}

// Returns the same mission as one snapshot.
std::shared_ptr<JournalBytes> WriteSnapshot() {
  auto bytes = Write(testing::MakeSmallMission());
  bytes->wants_snapshot = true;
  const auto store = Open(bytes);
  EXPECT_TRUE(store.ok()) << store.status();
  EXPECT_TRUE((*store)->RunFusionUntilIdle("m").ok());
  EXPECT_TRUE(bytes->records.empty());
  return bytes;
}

std::string Describe(const MapStore& store) {
  std::string text;
  const Page<LocalMapInfo> maps = *store.ListLocalMaps("m", {});
  for (const LocalMapInfo& map : maps.items) {
    absl::StrAppend(&text, map.agent, " ", ToString(map.island), " ", map.last_batch, " ",
                    map.keyframes, " ", map.settled_keyframes, " ", map.placed_keyframes, " ",
                    map.map_points, " ", map.tracked_frames, " ", map.lost_frames, " ",
                    map.parked_references, "\n");
  }
  const MissionStatistics statistics = *store.GetStatistics("m");
  absl::StrAppend(&text, statistics.revision, " ", statistics.map_points, " ",
                  statistics.overlaps_accepted, " ", statistics.merge_ms.size());
  return text;
}

TEST(RecoveryTest, ReadsBackWhatWasWritten) {
  const auto store = Open(Write(testing::MakeSmallMission()));
  ASSERT_TRUE(store.ok()) << store.status();
  // The first robot replaced a point, removed a point and a keyframe, and refers to a point that
  // never came; a point of each robot is one landmark.
  EXPECT_EQ(Describe(**store),
            "a 0000000000000001 2 3 3 2 4 4 1 1\n"
            "b 0000000000000001 1 4 1 2 6 4 0 0\n"
            "2 9 1 1");
}

TEST(RecoveryTest, ASnapshotSaysTheSameAsItsRecords) {
  const auto from_records = Open(Write(testing::MakeSmallMission()));
  const auto from_snapshot = Open(WriteSnapshot());
  ASSERT_TRUE(from_snapshot.ok()) << from_snapshot.status();
  EXPECT_EQ(Describe(**from_snapshot), Describe(**from_records));
}

TEST(RecoveryTest, LowerLimitsThanBeforeAreNoDamage) {
  MapStoreOptions options;
  options.max_keypoints_per_keyframe = 1;
  options.max_keyframe_bytes = 1;
  options.max_items_per_batch = 1;
  options.max_parked_references = 1;
  options.max_bytes_per_agent = 1;
  EXPECT_TRUE(Open(Write(testing::MakeSmallMission()), options).ok());
  EXPECT_TRUE(Open(WriteSnapshot(), options).ok());
}

// Sessions are not in the journal, but what they let expire must not come back.
TEST(RecoveryTest, WhatWaitedTooLongStaysGone) {
  MapStoreOptions options;
  options.deterministic = true;
  options.max_parked_s = 10;
  absl::Time now = absl::UnixEpoch();
  const auto bytes = Write({testing::MakeSmallMission()[0]});
  const auto store = std::make_unique<MapStore>(
      options, nullptr, std::make_unique<ByteJournal>(bytes), nullptr, [&now] { return now; });
  ASSERT_TRUE(testing::RecoverUndamaged(*store).ok());
  const auto send = [&](const MapUpdateBatch& batch) {
    const auto opened = store->OpenSession({"m", "a", 0, {kSmallMapA}});
    ASSERT_TRUE(opened.ok()) << opened.status();
    const auto acknowledged = store->Apply(opened->session_id, batch);
    ASSERT_TRUE(acknowledged.ok()) << acknowledged.status();
  };
  MapUpdateBatch early;
  early.local_map = kSmallMapA;
  early.number = 2;
  early.observations = {{ObservationChange::Kind::kAdded, {kSmallMapA, 9}, {kSmallMapA, 0}, 7}};
  send(early);
  now += absl::Seconds(20);
  MapUpdateBatch late;
  late.local_map = kSmallMapA;
  late.number = 3;
  FullMapPoint point;
  point.id = {kSmallMapA, 9};
  late.full_points = {point};
  send(late);
  EXPECT_EQ(store->GetKeyframe("m", {kSmallMapA, 0})->observed_points, 6u);
  const auto again = Open(bytes, options);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->GetKeyframe("m", {kSmallMapA, 0})->observed_points, 6u);
}

struct RecordDamage {
  std::string name;
  size_t record;
  std::function<void(JournalRecord&)> damage;
};

template <typename Change>
std::function<void(JournalRecord&)> InBatch(Change change) {
  return [change](JournalRecord& record) {
    auto& batch_record = std::get<BatchRecord>(record);
    auto batch = std::make_shared<MapUpdateBatch>(*batch_record.batch);
    change(*batch);
    batch_record.batch = std::move(batch);
  };
}
template <typename Change>
std::function<void(JournalRecord&)> InFuse(Change change) {
  return [change](JournalRecord& record) { change(std::get<FuseRecord>(record).plan); };
}

std::vector<RecordDamage> MakeRecordDamages() {
  constexpr size_t kBatch = 0;
  constexpr size_t kQuery = 2;
  constexpr size_t kFuse = 3;
  constexpr size_t kRefused = 7;
  return {
      {"AMissingBatch", kBatch, InBatch([](MapUpdateBatch& batch) { batch.number = 2; })},
      {"ACameraThatWasNeverSent", kBatch,
       InBatch([](MapUpdateBatch& batch) { batch.cameras.clear(); })},
      {"APoseOfNaN", kBatch, InBatch([](MapUpdateBatch& batch) {
         batch.full_keyframes[1].camera_from_local.translation.x() =
             std::numeric_limits<double>::quiet_NaN();
       })},
      {"AnUnknownKind", kBatch, InBatch([](MapUpdateBatch& batch) {
         batch.observations[0].kind = static_cast<ObservationChange::Kind>(2);
       })},
      {"AnotherAgent", 4, [](JournalRecord& record) { std::get<BatchRecord>(record).agent = "b"; }},
      {"AnUnknownVerdict", kQuery,
       [](JournalRecord& record) {
         std::get<QueryRecord>(record).overlaps[0].verdict = static_cast<OverlapVerdict>(99);
       }},
      {"AQueryOfNobody", kQuery,
       [](JournalRecord& record) { std::get<QueryRecord>(record).task.against = kNobody; }},
      {"AnIslandFusedWithItself", kFuse, InFuse([](auto& plan) { plan.source = plan.target; })},
      {"AKeyframeOfNobody", kFuse, InFuse([](auto& plan) {
         plan.keyframes[{kNobody, 0}] = {};
       })},
      {"ARejectedNothing", kFuse, InFuse([](auto& plan) {
         plan.rejected_raw[{{kSmallMapA, 0}, 99}] = {};
       })},
      {"AnOverlapNobodyFound", kFuse, InFuse([](auto& plan) { plan.overlaps = {5}; })},
      {"AnOriginThatIsNoPlace", kRefused,
       [](JournalRecord& record) {
         ProfileRecord profile;
         profile.profile.origin = GeoOrigin{std::numeric_limits<double>::quiet_NaN(), 0, 0, 0};
         record = profile;
       }},
      {"ALocalMapThatNobodyBent", kRefused,
       [](JournalRecord& record) { std::get<FuseRefusedRecord>(record).relaxed = {kNobody}; }}};
}

class DamagedRecordTest : public ::testing::TestWithParam<RecordDamage> {};

TEST_P(DamagedRecordTest, IsRefused) {
  Records records = testing::MakeSmallMission();
  GetParam().damage(records[GetParam().record]);
  const absl::Status status = Open(Write(records)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status;
}
INSTANTIATE_TEST_SUITE_P(All, DamagedRecordTest, ::testing::ValuesIn(MakeRecordDamages()),
                         [](const auto& info) { return info.param.name; });

struct StateDamage {
  std::string name;
  std::function<void(MissionState&)> damage;
};

LocalMapState& MapA(MissionState& state) { return state.local_maps.at(kSmallMapA); }

std::vector<StateDamage> MakeStateDamages() {
  return {
      {"ALocalMapInTwoPlaces", [](auto& state) { std::swap(state.order[0], state.order[1]); }},
      {"AProfileOfTooManyBytes", [](auto& state) { state.profile.description.assign(2000, 'x'); }},
      {"ALocalMapOfNobody", [](auto& state) { state.agents.at("a").local_maps.clear(); }},
      {"ANameThatIsNone", [](auto& state) { state.agents["?"]; }},
      {"ALocalMapWithoutIsland", [](auto& state) { state.global.island_of.erase(kSmallMapB); }},
      {"AnIslandOfNobody",
       [](auto& state) {
         state.global.islands[kNobody].id = kNobody;
         state.global.islands[kNobody].local_maps = {kNobody};
       }},
      {"ARelaxedNobody",
       [](auto& state) { state.global.islands.at(kSmallMapA).relaxed = {kNobody}; }},
      {"AKeyframeThatNeverArrived",
       [](auto& state) {
         MapA(state).arrival.erase({kSmallMapA, 1});
       }},
      {"MoreSettledThanArrived", [](auto& state) { MapA(state).settled = 99; }},
      {"AKeypointThatIsNotThere",
       [](auto& state) {
         MapA(state).foreign_observations[{kSmallMapA, 1}][99] = {kSmallMapB, 0};
       }},
      {"ALandmarkOfNobody",
       [](auto& state) {
         state.global.landmarks.Merge({kSmallMapA, 0}, {kNobody, 0});
       }},
      {"ALandmarkOfWhatWasRemoved",
       [](auto& state) {
         state.global.landmarks.Merge({kSmallMapA, 0}, {kSmallMapA, 3});
       }},
      {"AnOverlapOfTomorrow", [](auto& state) { state.next_overlap = 1; }},
      {"AnOverlapOfNobody",
       [](auto& state) {
         state.global.overlaps.Change(1,
                                      [](auto& entry) { entry.overlap.query.local_map = kNobody; });
       }},
      {"AnOverlapInNoState",
       [](auto& state) {
         state.global.overlaps.Change(
             1, [](auto& entry) { entry.state = static_cast<OverlapState>(-1); });
       }},
      {"AQueryOfNobody",
       [](auto& state) {
         state.queries.Push({kNobody, 0}, {kNobody});
       }},
      {"ARejectedNothing",
       [](auto& state) {
         state.global.rejected[{{kSmallMapA, 0}, 99}] = {};
       }},
      {"APlacedNobody",
       [](auto& state) {
         state.global.keyframes[{kNobody, 0}] = {};
       }},
      {"ADisplacedNobody",
       [](auto& state) {
         state.FindIslandOf(kSmallMapA)->displaced.insert({kNobody, 0});
       }},
      {"ACameraOfNoSize",
       [](auto& state) { MapA(state).cameras = {std::make_shared<const Camera>()}; }},
      {"APointOfNaN",
       [](auto& state) {
         MapA(state).map.SetPosition(
             {kSmallMapA, 0}, Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
       }},
      {"AKeyframeOfNaN", [](auto& state) {
         Rigid3d pose;
         pose.translation.x() = std::numeric_limits<double>::quiet_NaN();
         MapA(state).map.SetPose({kSmallMapA, 0}, pose);
       }}};
}

class DamagedStateTest : public ::testing::TestWithParam<StateDamage> {};

TEST_P(DamagedStateTest, IsRefused) {
  const auto bytes = WriteSnapshot();
  const FeatureLoader load = [](KeyframeId) { return testing::MakeSmallFeatures(); };
  auto state = map_store::DecodeState(bytes->snapshot, load);
  ASSERT_TRUE(state.ok()) << state.status();
  GetParam().damage(*state);
  const auto damaged = map_store::DecodeState(map_store::EncodeState(*state), load);
  EXPECT_EQ(damaged.status().code(), absl::StatusCode::kDataLoss) << damaged.status();
}
INSTANTIATE_TEST_SUITE_P(All, DamagedStateTest, ::testing::ValuesIn(MakeStateDamages()),
                         [](const auto& info) { return info.param.name; });

TEST(RecoveryTest, EveryCutIsRefused) {
  const std::string snapshot = WriteSnapshot()->snapshot;
  const FeatureLoader load = [](KeyframeId) { return testing::MakeSmallFeatures(); };
  for (size_t size = 0; size < snapshot.size(); size += 7) {
    EXPECT_FALSE(map_store::DecodeState({snapshot.data(), size}, load).ok()) << size;
  }
}

TEST(RecoveryTest, FeaturesThatCannotBeAreRefused) {
  auto bytes = WriteSnapshot();
  KeyframePayload payload;
  payload.features = testing::MakeSmallFeatures();
  payload.features.keypoints[3].x_px = std::numeric_limits<float>::infinity();
  bytes->features[{kSmallMapA, 1}] = map_store::EncodeFeatures(payload);
  EXPECT_EQ(Open(bytes).status().code(), absl::StatusCode::kDataLoss);
}

KeyframePayload PlausiblePayload() {
  KeyframePayload payload;
  payload.camera = std::make_shared<const Camera>(
      Camera{.fx_px = 700, .fy_px = 700, .width_px = 1241, .height_px = 376});
  payload.features = testing::MakePlausibleFeatures(1, 2000, {1241, 376});
  return payload;
}

TEST(CodedFeaturesTest, AreKeptToTheBitInHalfTheBytes) {
  const KeyframePayload payload = PlausiblePayload();
  const std::string bytes = map_store::EncodeFeatures(payload);
  const auto read = map_store::DecodeFeatures(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->keypoints, payload.features.keypoints);
  EXPECT_EQ(read->descriptors, payload.features.descriptors);
  EXPECT_LT(bytes.size(), 45'000u);
}

TEST(CodedFeaturesTest, CodeThatIsAtHandIsKeptAsItIs) {
  KeyframePayload payload = PlausiblePayload();
  const std::string coded = map_store::EncodeFeatures(payload);
  // The code begins after a mark of 8 bytes.
  const auto code = std::make_shared<const std::string>(coded.substr(8) + "!");
  payload.code = code;
  EXPECT_EQ(map_store::EncodeFeatures(payload), coded + "!");
}

TEST(CodedFeaturesTest, WhatNeverPassedTheWireIsKeptToTheBitAsWell) {
  KeyframePayload payload = PlausiblePayload();
  payload.features.keypoints[7].x_px += 0.001f;
  const auto read = map_store::DecodeFeatures(map_store::EncodeFeatures(payload));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->keypoints, payload.features.keypoints);
}

TEST(CodedFeaturesTest, OfOlderJournalsAreRead) {
  const KeyframePayload payload = PlausiblePayload();
  ArchiveWriter plain;
  plain(payload.features);
  const auto read = map_store::DecodeFeatures(plain.Take());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->keypoints, payload.features.keypoints);
}

TEST(CodedFeaturesTest, DamageIsDataLoss) {
  const std::string bytes = map_store::EncodeFeatures(PlausiblePayload());
  for (size_t at = 8; at < bytes.size(); at += 997) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    EXPECT_TRUE(absl::IsDataLoss(map_store::DecodeFeatures(damaged).status())) << at;
    EXPECT_TRUE(absl::IsDataLoss(map_store::DecodeFeatures(bytes.substr(0, at)).status())) << at;
  }
}

}  // namespace
}  // namespace corbslam::map_store
