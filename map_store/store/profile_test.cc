// Tests what people set of missions: kept, held, and followed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/ingest/mission_limits.h"
#include "map_store/joining/forgetting.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/blank_batch.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/recover_undamaged.h"

namespace corbslam::map_store {
namespace {

using testing::BlankBatch;

using testing::ByteJournal;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::JournalBytes;

constexpr LocalMapId kLimitedA{0xa};
constexpr LocalMapId kLimitedB{0xb};

// A journal that says how much of the disk missions take.
class MeasuredJournal : public ByteJournal {
 public:
  using ByteJournal::ByteJournal;
  uint64_t DiskBytes(absl::string_view) const override { return disk_bytes; }
  absl::Status DeleteMission(absl::string_view mission) override {
    deleted.emplace_back(mission);
    return absl::OkStatus();
  }
  uint64_t disk_bytes = 0;
  std::vector<std::string> deleted;
};

class ProfileTest : public ::testing::Test {
 protected:
  ProfileTest() { Start(); }

  void Start() {
    store_.reset();
    options_.deterministic = true;
    auto journal = std::make_unique<MeasuredJournal>(bytes_);
    journal_ = journal.get();
    store_ = std::make_unique<MapStore>(options_, nullptr, std::move(journal), nullptr,
                                        [this] { return now_; });
    if (!bytes_->records.empty() || !bytes_->snapshot.empty()) {
      ASSERT_TRUE(testing::RecoverUndamaged(*store_).ok());
    }
  }
  MissionProfile Profile() { return store_->GetMission("m")->profile; }
  absl::Status Set(const MissionProfile& values, const std::vector<ProfileField>& fields) {
    return store_->UpdateMission("m", values, fields);
  }
  absl::Status SetLimits(const MissionLimits& limits) {
    MissionProfile values;
    values.limits = limits;
    return Set(values, {ProfileField::kLimits});
  }
  absl::Status SetRetention(absl::Duration retention) {
    MissionProfile values;
    values.retention_s = static_cast<uint64_t>(absl::ToInt64Seconds(retention));
    return Set(values, {ProfileField::kRetention});
  }
  uint64_t Open(const std::string& agent, const std::vector<LocalMapId>& local_maps = {}) {
    SessionRequest request;
    request.mission = "m";
    request.agent = agent;
    request.local_maps = local_maps;
    return store_->OpenSession(request)->session_id;
  }
  static MapUpdateBatch End(LocalMapId local_map, uint64_t number) {
    MapUpdateBatch batch;
    batch.local_map = local_map;
    batch.number = number;
    batch.closes_local_map = true;
    return batch;
  }
  static void ExpectTooMuch(const absl::Status& status, const std::vector<std::string>& says) {
    EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
    for (const std::string& part : says) {
      EXPECT_THAT(std::string(status.message()), HasSubstr(part));
    }
  }
  static void ExpectRefusedBytes(const absl::Status& status) {
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("at most 1048576"));
  }
  bool IsThere() { return store_->GetMission("m").ok(); }

  MapStoreOptions options_;
  absl::Time now_ = absl::FromUnixSeconds(1'700'000'000);
  std::shared_ptr<JournalBytes> bytes_ = std::make_shared<JournalBytes>();
  std::unique_ptr<MapStore> store_;
  MeasuredJournal* journal_ = nullptr;
};

TEST_F(ProfileTest, AMissionMadeAheadStaysWithoutRobotsAndOverARestart) {
  MissionProfile wanted;
  wanted.description = "the old mine";
  wanted.labels = {{"site", "3"}};
  wanted.limits.keyframes = 5;
  wanted.agent_limits["a"].keyframes = 4;
  wanted.retention_s = 100;
  wanted.origin = GeoOrigin{1, 2, 3, 4};
  ASSERT_TRUE(store_->CreateMission("m", wanted).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(store_->CreateMission("m", {})));
  MissionProfile expected = wanted;
  expected.created_ns = expected.last_used_ns = absl::ToUnixNanos(now_);
  EXPECT_EQ(Profile(), expected);
  store_->CloseSession(Open("a"));
  EXPECT_TRUE(IsThere());
  Start();
  EXPECT_EQ(Profile(), expected);
  // It is the same from a snapshot.
  bytes_->wants_snapshot = true;
  ASSERT_TRUE(store_->RunFusionUntilIdle("m").ok());
  EXPECT_THAT(bytes_->records, IsEmpty());
  Start();
  EXPECT_EQ(Profile(), expected);
}

TEST_F(ProfileTest, WhatIsNoMissionIsNotMade) {
  EXPECT_TRUE(absl::IsInvalidArgument(store_->CreateMission("a/b", {})));
  MissionProfile wrong;
  wrong.origin = GeoOrigin{100, 0, 0, 0};
  EXPECT_TRUE(absl::IsInvalidArgument(store_->CreateMission("m", wrong)));
  EXPECT_FALSE(IsThere());
  EXPECT_THAT(bytes_->records, IsEmpty());
  EXPECT_TRUE(absl::IsNotFound(SetLimits({})));
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(Set(wrong, {ProfileField::kOrigin})));
  EXPECT_FALSE(Profile().origin.has_value());
  options_.max_missions = 1;
  Start();
  EXPECT_TRUE(absl::IsResourceExhausted(store_->CreateMission("n", {})));
}

TEST_F(ProfileTest, OfTwoChangesOfOneRevisionTheSecondIsAborted) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  MissionProfile values;
  values.description = "first";
  ASSERT_TRUE(store_->UpdateMission("m", values, {ProfileField::kDescription}, 0).ok());
  values.description = "second";
  const absl::Status late = store_->UpdateMission("m", values, {ProfileField::kDescription}, 0);
  EXPECT_TRUE(absl::IsAborted(late)) << late;
  EXPECT_THAT(std::string(late.message()), HasSubstr("settings_revision 1"));
  EXPECT_EQ(Profile().description, "first");
  Start();
  EXPECT_EQ(Profile().revision, 1u);
}

TEST_F(ProfileTest, RobotsSettingsGrowInVersionAndLast) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  const std::string signature(64, 's');
  ASSERT_TRUE(store_->SetRobotSettings("m", "a", {3, "three", signature}).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(store_->SetRobotSettings("m", "a", {3, "x", signature})));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->SetRobotSettings("m", "a", {4, "x", "short"})));
  EXPECT_TRUE(absl::IsInvalidArgument(store_->SetRobotSettings("m", "a b", {4, "x", signature})));
  EXPECT_TRUE(absl::IsNotFound(store_->SetRobotSettings("n", "a", {4, "x", signature})));
  ASSERT_TRUE(store_->SetRobotSettings("m", "", {1, "all", signature}).ok());
  Start();
  SettingsVersions told;
  const uint64_t session = Open("a");
  const std::vector<SignedSettings> settings = store_->NewerSettings(session, told);
  ASSERT_EQ(settings.size(), 2u);
  EXPECT_EQ(settings[0].bytes, "all");
  EXPECT_EQ(settings[1].bytes, "three");
  EXPECT_THAT(store_->NewerSettings(session, told), IsEmpty());
  // Of all robots together there is a bound.
  const std::string large(64 << 10, 'x');
  absl::Status status;
  for (int i = 0; i < 20; ++i) {
    status.Update(store_->SetRobotSettings("m", absl::StrCat("r", i), {1, large, signature}));
  }
  ExpectRefusedBytes(status);
}

TEST_F(ProfileTest, AChangeIsOfItsFieldsAndLasts) {
  MissionProfile values;
  values.description = "before";
  values.limits.keyframes = 9;
  ASSERT_TRUE(store_->CreateMission("m", values).ok());
  values.description = "after";
  values.limits.keyframes = 1;
  ASSERT_TRUE(Set(values, {ProfileField::kDescription}).ok());
  Start();
  EXPECT_EQ(Profile().description, "after");
  EXPECT_EQ(Profile().limits.keyframes, 9u);
}

TEST_F(ProfileTest, AMissionOfRobotsBeginsWithItsFirstBatch) {
  const uint64_t a = Open("a");
  now_ += absl::Seconds(5);
  const int64_t begin_ns = absl::ToUnixNanos(now_);
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kLimitedA, 1)).ok());
  now_ += absl::Minutes(5);
  const int64_t last_ns = absl::ToUnixNanos(now_);
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kLimitedA, 2)).ok());
  EXPECT_EQ(Profile().created_ns, begin_ns);
  EXPECT_EQ(Profile().last_used_ns, last_ns);
  Start();
  EXPECT_EQ(Profile().created_ns, begin_ns);
  EXPECT_EQ(Profile().last_used_ns, last_ns);
}

TEST_F(ProfileTest, KeyframesOfAMissionAndOfAnAgent) {
  MissionProfile values;
  values.limits.keyframes = 3;
  values.agent_limits["a"].keyframes = 2;
  ASSERT_TRUE(store_->CreateMission("m", values).ok());
  const uint64_t a = Open("a");
  const uint64_t b = Open("b");
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kLimitedA, 1)).ok());
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kLimitedA, 2)).ok());
  ExpectTooMuch(store_->Apply(a, BlankBatch(kLimitedA, 3)).status(),
                {"agent a of mission m has 2 keyframes", "1 more", "agent_limits[a].keyframes",
                 "is 2", "batch 3"});
  ASSERT_TRUE(store_->Apply(b, BlankBatch(kLimitedB, 1)).ok());
  ExpectTooMuch(store_->Apply(b, BlankBatch(kLimitedB, 2)).status(),
                {"mission m has 3 keyframes", "limits.keyframes", "is 3"});
  EXPECT_EQ(store_->GetMission("m")->keyframes, 3u);
  // What was stored is acknowledged, and a local map can be closed.
  EXPECT_EQ(store_->Apply(a, BlankBatch(kLimitedA, 2))->number, 2u);
  EXPECT_TRUE(store_->Apply(a, End(kLimitedA, 3)).ok());
  // Sessions that stand go on under new limits.
  ASSERT_TRUE(SetLimits({.keyframes = 4}).ok());
  EXPECT_TRUE(store_->Apply(b, BlankBatch(kLimitedB, 2)).ok());
  ASSERT_TRUE(SetLimits({.keyframes = 1}).ok());
  ExpectTooMuch(store_->Apply(b, BlankBatch(kLimitedB, 3)).status(), {"has 4 keyframes", "is 1 "});
}

TEST_F(ProfileTest, MemoryAndDiskOfAMission) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kLimitedA, 1, 1000)).ok());
  const uint64_t memory = store_->GetMission("m")->memory_bytes;
  ASSERT_TRUE(SetLimits({.memory_bytes = memory + 1000}).ok());
  ExpectTooMuch(store_->Apply(a, BlankBatch(kLimitedA, 2, 1000)).status(),
                {absl::StrCat("mission m has ", memory, " bytes in memory"), "limits.memory_bytes",
                 absl::StrCat("is ", memory + 1000)});
  ASSERT_TRUE(SetLimits({.disk_bytes = 10'000}).ok());
  journal_->disk_bytes = 9'999;
  ExpectTooMuch(store_->Apply(a, BlankBatch(kLimitedA, 2, 1000)).status(),
                {"mission m has 9999 bytes on disk", "limits.disk_bytes", "is 10000"});
  EXPECT_EQ(store_->GetMission("m")->keyframes, 1u);
  journal_->disk_bytes = 0;
  EXPECT_TRUE(store_->Apply(a, BlankBatch(kLimitedA, 2, 10)).ok());
}

TEST_F(ProfileTest, TheStoresOwnLimitsHoldAsWell) {
  options_.max_bytes_per_mission = 20'000;
  Start();
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  ASSERT_TRUE(SetLimits({.keyframes = 1'000'000, .memory_bytes = uint64_t{1} << 40}).ok());
  const uint64_t a = Open("a");
  ExpectTooMuch(store_->Apply(a, BlankBatch(kLimitedA, 1, 1000)).status(),
                {"mission m has", "20000"});
}

TEST_F(ProfileTest, AnAgentSendsNoFasterThanItMayButForABurst) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  const uint64_t a = Open("a");
  EXPECT_EQ(store_->PaceUplink(a, 1u << 30), absl::ZeroDuration());
  ASSERT_TRUE(SetLimits({.uplink_bytes_per_second = 100'000}).ok());
  EXPECT_LT(store_->PaceUplink(a, 1 << 20), absl::Milliseconds(1));
  const absl::Duration wait = store_->PaceUplink(a, 200'000);
  EXPECT_GE(wait, absl::Seconds(2));
  EXPECT_LT(wait, absl::Seconds(2.1));
  // Another session of the agent owes what the first did; another agent owes nothing.
  EXPECT_GE(store_->PaceUplink(Open("a"), 0), absl::Seconds(2));
  EXPECT_EQ(store_->PaceUplink(Open("b"), 0), absl::ZeroDuration());
  now_ += wait;
  EXPECT_EQ(store_->PaceUplink(Open("a"), 0), absl::ZeroDuration());
  ASSERT_TRUE(SetLimits({}).ok());
  EXPECT_EQ(store_->PaceUplink(a, 1u << 30), absl::ZeroDuration());
}

TEST_F(ProfileTest, WhatNobodyUsesForItsRetentionIsDeleted) {
  std::vector<std::string> told;
  store_->SetExpiryListener([&told](const std::string& mission, const std::string& why) {
    told.push_back(absl::StrCat(mission, " ", why));
  });
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  now_ += absl::Hours(24 * 400);
  store_->TendMissions();
  EXPECT_TRUE(IsThere()) << "it has no retention";
  ASSERT_TRUE(SetRetention(absl::Hours(48)).ok());
  now_ += absl::Hours(47);
  store_->TendMissions();
  // What its entry in the list says is no use of it; what is in it is.
  EXPECT_TRUE(store_->ListAgents("m", {}).ok());
  now_ += absl::Hours(47);
  EXPECT_TRUE(IsThere());
  EXPECT_EQ(store_->ListMissions({})->items.size(), 1u);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  now_ += absl::Hours(1);
  store_->TendMissions();
  EXPECT_FALSE(IsThere());
  EXPECT_THAT(journal_->deleted, ::testing::ElementsAre("m"));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_THAT(told[0], HasSubstr("m nobody has used it since 20"));
  EXPECT_THAT(told[0], HasSubstr("retention is 172800 s"));
}

TEST_F(ProfileTest, WithARobotOrAWatcherItStays) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  ASSERT_TRUE(SetRetention(absl::Hours(1)).ok());
  const uint64_t a = Open("a");
  now_ += absl::Hours(500);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  store_->CloseSession(a);
  const uint64_t watcher = *store_->AddMapListener("m", [] {});
  now_ += absl::Hours(500);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  // It was used until now.
  store_->RemoveMapListener("m", watcher);
  now_ += absl::Minutes(59);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  now_ += absl::Minutes(1);
  store_->TendMissions();
  EXPECT_FALSE(IsThere());
}

TEST_F(ProfileTest, AClockThatJumpsBackDeletesNothing) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  ASSERT_TRUE(SetRetention(absl::Hours(1)).ok());
  now_ -= absl::Hours(24 * 365);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  // It counts from its next use on.
  EXPECT_TRUE(store_->ListAgents("m", {}).ok());
  now_ += absl::Minutes(59);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  now_ += absl::Minutes(1);
  store_->TendMissions();
  EXPECT_FALSE(IsThere());
}

TEST_F(ProfileTest, UsesAreWrittenDownOnceAnHourAndNeverCountedTooEarly) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  ASSERT_TRUE(SetRetention(absl::Hours(10)).ok());
  const size_t written = bytes_->records.size();
  for (int minute = 0; minute < 100; ++minute) {
    now_ += absl::Minutes(1);
    EXPECT_TRUE(store_->GetStatistics("m").ok());
    store_->TendMissions();
  }
  EXPECT_EQ(bytes_->records.size(), written + 1);
  const int64_t used_ns = Profile().last_used_ns;
  EXPECT_EQ(used_ns, absl::ToUnixNanos(now_));
  Start();
  const absl::Time known = absl::FromUnixNanos(Profile().last_used_ns);
  EXPECT_LT(now_ - known, absl::Hours(1));
  now_ = known + absl::Hours(11) - absl::Seconds(1);
  store_->TendMissions();
  EXPECT_TRUE(IsThere());
  now_ += absl::Seconds(1);
  store_->TendMissions();
  EXPECT_FALSE(IsThere());
}

TEST_F(ProfileTest, ARestoredMissionsRetentionBeginsAnew) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  ASSERT_TRUE(SetRetention(absl::Hours(1)).ok());
  MissionBackup backup = *store_->BackUpMission("m");
  now_ += absl::Hours(9);
  MapStore other(options_, nullptr, std::make_unique<InMemoryJournal>(), nullptr,
                 [this] { return now_; });
  MissionRestorer restorer = other.StartRestoring();
  for (std::string piece = backup.Next(1 << 20); !piece.empty(); piece = backup.Next(1 << 20)) {
    ASSERT_TRUE(restorer.Add(piece).ok());
  }
  ASSERT_TRUE(other.RestoreMission("again", *restorer.Finish()).ok());
  other.TendMissions();
  const auto info = other.GetMission("again");
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->profile.retention_s, 3600u);
  EXPECT_EQ(info->profile.last_used_ns, absl::ToUnixNanos(now_));
  EXPECT_EQ(info->profile.created_ns, Profile().created_ns);
}

// Returns a mission of so many local maps, all in one island.
MissionState MakeJoined(size_t count, bool closed) {
  MissionState state;
  state.name = "m";
  for (uint64_t i = 1; i <= count; ++i) {
    AddLocalMap(state, LocalMapId{i}, "a").closed = closed;
    if (i == 1) continue;
    state.global.islands.erase(LocalMapId{i});
    state.global.island_of[LocalMapId{i}] = LocalMapId{1};
    state.global.islands[LocalMapId{1}].local_maps.push_back(LocalMapId{i});
  }
  return state;
}

TEST(LocalMapLimitTest, ThoseThatAreClosedAndJoinedDoNotCount) {
  MapStoreOptions options;
  options.max_local_maps_per_mission = 10;
  MissionState state = MakeJoined(1500, /*closed=*/true);
  EXPECT_EQ(CountLimitedLocalMaps(state), 0u);
  EXPECT_TRUE(CheckRoomForLocalMap(state, options).ok());
  // One that is closed and alone counts, and so does one that is open and joined.
  AddLocalMap(state, LocalMapId{2000}, "b").closed = true;
  state.FindLocalMap(LocalMapId{7})->closed = false;
  EXPECT_EQ(CountLimitedLocalMaps(state), 2u);
  for (uint64_t i = 0; i < 8; ++i) AddLocalMap(state, LocalMapId{3000 + i}, "b");
  const absl::Status full = CheckRoomForLocalMap(state, options);
  EXPECT_TRUE(absl::IsResourceExhausted(full));
  EXPECT_THAT(std::string(full.message()), HasSubstr("has 10 local maps"));
  EXPECT_THAT(std::string(full.message()), HasSubstr("of 1509; the limit is 10"));
  EXPECT_TRUE(CheckLocalMaps(state, options).ok());
}

TEST(LocalMapLimitTest, NoMissionHasMoreThanMessagesCanName) {
  const MissionState state = MakeJoined(kMaxLocalMapsInAll, /*closed=*/true);
  const absl::Status full = CheckRoomForLocalMap(state, MapStoreOptions());
  EXPECT_TRUE(absl::IsResourceExhausted(full));
  EXPECT_THAT(std::string(full.message()), HasSubstr("no mission has more than 10000"));
  // An island whose own local map was deleted keeps that one's name.
  MissionState of_a_deleted = MakeJoined(kMaxLocalMapsInAll, /*closed=*/true);
  ForgetLocalMaps({LocalMapId{1}}, of_a_deleted);
  ASSERT_TRUE(of_a_deleted.global.islands.contains(LocalMapId{1}));
  EXPECT_TRUE(absl::IsResourceExhausted(CheckRoomForLocalMap(of_a_deleted, MapStoreOptions())));
  EXPECT_TRUE(CheckLocalMaps(of_a_deleted, MapStoreOptions()).ok());
  ForgetLocalMaps({LocalMapId{2}}, of_a_deleted);
  EXPECT_TRUE(CheckRoomForLocalMap(of_a_deleted, MapStoreOptions()).ok());
}

TEST(LocalMapLimitTest, ARobotThatStartedOftenStartsAgain) {
  MapStoreOptions options;
  options.deterministic = true;
  options.max_local_maps_per_mission = 10;
  MapStore store(options, nullptr, std::make_unique<InMemoryJournal>(), nullptr);
  ASSERT_TRUE(store.RestoreMission("m", MakeJoined(1500, /*closed=*/true)).ok());
  SessionRequest request;
  request.mission = "m";
  request.agent = "a";
  const auto session = store.OpenSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  MapUpdateBatch batch;
  batch.local_map = LocalMapId{5000};
  batch.number = 1;
  EXPECT_TRUE(store.Apply(session->session_id, batch).ok());
  EXPECT_EQ(store.GetMission("m")->local_maps, 1501u);
  EXPECT_TRUE(
      absl::IsResourceExhausted(store.RestoreMission("n", MakeJoined(11, /*closed=*/false))));
}

}  // namespace
}  // namespace corbslam::map_store
