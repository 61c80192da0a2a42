// Tests what any journal does that keeps records; one that keeps none passes the rest.
#include "map_store/testing/journal_conformance.h"

#include <gmock/gmock.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/record_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/testing/blank_batch.h"
#include "map_store/testing/feature_mission.h"
#include "map_store/testing/grey_jpeg.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/small_mission.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "slam/util/checksum.h"

namespace corbslam::testing {

using map_store::BatchRecord;
using map_store::Journal;
using map_store::JournalRecord;
using map_store::JournalSnapshot;
using map_store::MapStore;
using map_store::MissionIdentity;
using map_store::MissionList;
using map_store::MissionState;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace {

constexpr size_t kFeatures = 300;

std::string SumOf(const std::string& bytes) { return absl::StrCat(ExtendCrc32c(0, bytes)); }

std::string LineOf(const JournalRecord& record) {
  std::string line = absl::StrCat("record ", SumOf(map_store::EncodeRecord(record)));
  const auto* update = std::get_if<BatchRecord>(&record);
  if (update == nullptr) return line;
  for (const FullKeyframe& keyframe : update->batch->full_keyframes) {
    absl::StrAppend(&line, " ", SumOf(map_store::EncodeFeatures(*keyframe.payload)));
  }
  return line;
}

std::string LineOf(const MissionState& state) {
  std::string line = absl::StrCat("snapshot ", SumOf(map_store::EncodeState(state)));
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      absl::StrAppend(&line, " ", SumOf(map_store::EncodeFeatures(*keyframe.payload)));
    }
  }
  return line;
}

JournalRecord Blank(uint64_t number, size_t keypoints = 0, uint64_t local_map = 7) {
  return BatchRecord{
      .agent = "a",
      .batch = std::make_shared<const MapUpdateBatch>(BlankBatch({local_map}, number, keypoints)),
      .received_at = absl::UnixEpoch()};
}

std::vector<JournalRecord> Blanks(uint64_t first, uint64_t last) {
  std::vector<JournalRecord> records;
  for (uint64_t number = first; number <= last; ++number) records.push_back(Blank(number, 20));
  return records;
}

JournalRecord Removal(uint64_t number, uint32_t keyframe) {
  MapUpdateBatch batch;
  batch.local_map = LocalMapId{7};
  batch.number = number;
  batch.removed_keyframes = {{{{7}, keyframe}, {}, {}}};
  return BatchRecord{.agent = "a",
                     .batch = std::make_shared<const MapUpdateBatch>(std::move(batch)),
                     .received_at = absl::UnixEpoch()};
}

KeyframePicture Picture(uint32_t keyframe, size_t bytes = 1000) {
  return {{{7}, keyframe}, std::string(bytes, static_cast<char>('a' + keyframe)), 4};
}

JournalSnapshot SnapshotAt(Journal::Position position, uint32_t keyframes) {
  JournalSnapshot snapshot = map_store::TakeSnapshot(MakeFeatureMission("m", keyframes, kFeatures));
  snapshot.position = position;
  return snapshot;
}

std::vector<uint32_t> PicturesOf(const Journal& journal, const std::string& mission) {
  std::vector<uint32_t> found;
  const absl::Status visited =
      journal.ForEachPicture(mission, [&found](const KeyframePicture& picture) {
        found.push_back(picture.keyframe.index);
        return absl::OkStatus();
      });
  EXPECT_TRUE(visited.ok()) << visited;
  return found;
}

}  // namespace

void JournalConformance::Open(uint64_t min_bytes_between_snapshots) {
  journal_.reset();
  auto opened = place_->Open(min_bytes_between_snapshots);
  ASSERT_TRUE(opened.ok()) << opened.status();
  journal_ = *std::move(opened);
}

Journal::Position JournalConformance::Write(const std::string& mission,
                                            const std::vector<JournalRecord>& records) {
  Journal::Position last = 0;
  for (const JournalRecord& record : records) {
    const auto appended = journal_->Append(mission, record);
    EXPECT_TRUE(appended.ok()) << appended.status();
    if (!appended.ok()) return 0;
    EXPECT_GT(*appended, last);
    last = *appended;
  }
  const absl::Status synced = journal_->Sync(mission, last);
  EXPECT_TRUE(synced.ok()) << synced;
  return last;
}

std::vector<std::string> JournalConformance::Replay(const std::string& mission,
                                                    Journal::Replay replay) const {
  std::vector<std::string> lines;
  replay.on_snapshot = [&lines](const MissionState& state) {
    lines.push_back(LineOf(state));
    return absl::OkStatus();
  };
  replay.on_record = [&lines](const JournalRecord& record) {
    lines.push_back(LineOf(record));
    return absl::OkStatus();
  };
  const auto position = journal_->Recover(mission, replay);
  if (!position.ok()) return {position.status().ToString()};
  return lines;
}

std::vector<std::string> JournalConformance::LinesOf(const std::vector<JournalRecord>& records) {
  std::vector<std::string> lines;
  for (const JournalRecord& record : records) lines.push_back(LineOf(record));
  return lines;
}

TEST_P(DurableJournalConformance, GivesRecordsOfEveryKindBackInTheirOrder) {
  Open();
  const std::vector<JournalRecord> records = MakeSmallMission();
  const Journal::Position last = Write(kMission, records);
  EXPECT_EQ(Replay(kMission), LinesOf(records)) << "while it is open";
  Open();
  EXPECT_THAT(*journal_->ListMissions(), ElementsAre(kMission));
  EXPECT_EQ(Replay(kMission), LinesOf(records));
  Journal::Replay nothing;
  nothing.on_record = [](const JournalRecord&) { return absl::OkStatus(); };
  EXPECT_EQ(journal_->Recover(kMission, nothing).value_or(0), last);
}

TEST_P(DurableJournalConformance, GoesOnBehindWhatWasThere) {
  Open();
  const Journal::Position first = Write(kMission, Blanks(1, 3));
  Open();
  EXPECT_EQ(Replay(kMission).size(), 3u);
  EXPECT_GT(Write(kMission, Blanks(4, 6)), first);
  Open();
  EXPECT_EQ(Replay(kMission), LinesOf(Blanks(1, 6)));
}

TEST_P(DurableJournalConformance, WritesWhatWasPrepared) {
  Open();
  BatchRecord record = std::get<BatchRecord>(MakeSmallMission().front());
  journal_->Prepare(record);
  Write(kMission, {record});
  Open();
  EXPECT_EQ(Replay(kMission), LinesOf({MakeSmallMission().front()}));
}

TEST_P(DurableJournalConformance, GivesBackWhatIsManyMegabytes) {
  Open();
  const std::vector<JournalRecord> records = {Blank(1, 80'000), Blank(2), Blank(3, 30'000)};
  Write(kMission, records);
  Open();
  EXPECT_EQ(Replay(kMission), LinesOf(records));
}

TEST_P(DurableJournalConformance, AReplayEndsWhereItIsTold) {
  Open();
  Write(kMission, Blanks(1, 2));
  const Journal::Position until = Write(kMission, Blanks(3, 3));
  Write(kMission, Blanks(4, 5));
  Journal::Replay replay;
  replay.until = until;
  EXPECT_EQ(Replay(kMission, replay), LinesOf(Blanks(1, 3)));
}

TEST_P(DurableJournalConformance, AReplayGoesWithoutFeaturesIfItIsTold) {
  Open();
  ASSERT_TRUE(journal_->CreateMission(kMission, MakeFeatureMission("m", 3, kFeatures)).ok());
  Write(kMission, {Blank(1, 20)});
  Journal::Replay replay;
  replay.with_features = false;
  size_t keyframes = 0;
  replay.on_snapshot = [&](const MissionState& state) {
    keyframes = state.local_maps.begin()->second.map.keyframes().size();
    return absl::OkStatus();
  };
  size_t keypoints = 0;
  replay.on_record = [&](const JournalRecord& record) {
    const auto& batch = *std::get<BatchRecord>(record).batch;
    keypoints = batch.full_keyframes.at(0).payload->features.keypoints.size();
    return absl::OkStatus();
  };
  ASSERT_TRUE(journal_->Recover(kMission, replay).ok());
  EXPECT_EQ(keyframes, 3u);
  EXPECT_EQ(keypoints, 20u);
}

TEST_P(DurableJournalConformance, AReplayEndsWithItsCallersError) {
  Open();
  Write(kMission, Blanks(1, 2));
  Journal::Replay replay;
  replay.on_record = [](const JournalRecord&) { return absl::CancelledError("enough"); };
  EXPECT_TRUE(absl::IsCancelled(journal_->Recover(kMission, replay).status()));
  EXPECT_TRUE(journal_->Damage(kMission).ok());
}

TEST_P(JournalConformance, AMissionThatIsNotThereIsEmpty) {
  Open();
  EXPECT_THAT(Replay("nowhere"), IsEmpty());
  EXPECT_TRUE(journal_->Sync("nowhere", 3).ok());
  EXPECT_TRUE(journal_->DeleteMission("nowhere").ok());
  EXPECT_FALSE(journal_->WantsSnapshot("nowhere"));
  EXPECT_TRUE(journal_->Damage("nowhere").ok());
  EXPECT_TRUE(absl::IsNotFound(journal_->ReadSummary("nowhere").status()));
  EXPECT_EQ(journal_->DiskBytes("nowhere"), 0u);
  EXPECT_THAT(*journal_->ListMissions(), IsEmpty());
  EXPECT_TRUE(journal_->CheckWritable().ok());
}

TEST_P(DurableJournalConformance, ASnapshotStandsForTheRecordsBeforeIt) {
  Open(1000);
  ASSERT_TRUE(journal_->CreateMission(kMission, MakeFeatureMission("m", 3, kFeatures)).ok());
  EXPECT_FALSE(journal_->WantsSnapshot(kMission));
  const Journal::Position middle = Write(kMission, Blanks(1, 300));
  EXPECT_TRUE(journal_->WantsSnapshot(kMission));
  Write(kMission, Blanks(301, 302));
  ASSERT_TRUE(journal_->WriteSnapshot(kMission, SnapshotAt(middle, 2)).ok());
  EXPECT_FALSE(journal_->WantsSnapshot(kMission));
  std::vector<std::string> expected = LinesOf(Blanks(301, 302));
  expected.insert(expected.begin(), LineOf(MakeFeatureMission("m", 2, kFeatures)));
  EXPECT_EQ(Replay(kMission), expected);
  Open();
  EXPECT_EQ(Replay(kMission), expected);
}

TEST_P(DurableJournalConformance, ASnapshotMayComeAgainAtItsPosition) {
  Open();
  ASSERT_TRUE(journal_->CreateMission(kMission, MakeFeatureMission("m", 3, kFeatures)).ok());
  const Journal::Position last = Write(kMission, Blanks(1, 2));
  ASSERT_TRUE(journal_->WriteSnapshot(kMission, SnapshotAt(last, 3)).ok());
  ASSERT_TRUE(journal_->WriteSnapshot(kMission, SnapshotAt(last, 2)).ok());
  Open();
  EXPECT_THAT(Replay(kMission), ElementsAre(LineOf(MakeFeatureMission("m", 2, kFeatures))));
}

TEST_P(DurableJournalConformance, RemovedKeyframesWantASnapshotThatDropsTheirFeatures) {
  Open(1000);
  Write(kMission, {Blank(1, 3000), Blank(2, 10)});
  const Journal::Position last = Write(kMission, {Removal(3, 1)});
  EXPECT_TRUE(journal_->WantsSnapshot(kMission));
  ASSERT_TRUE(journal_->WriteSnapshot(kMission, SnapshotAt(last, 0)).ok());
  EXPECT_FALSE(journal_->WantsSnapshot(kMission));
}

TEST_P(DurableJournalConformance, AMissionThatWasMadeElsewhereComesBackWhole) {
  Open();
  const MissionState state = MakeFeatureMission("m", 70, kFeatures);
  ASSERT_TRUE(journal_->CreateMission(kMission, state).ok());
  EXPECT_GT(journal_->DiskBytes(kMission), 70 * kFeatures * 32);
  EXPECT_THAT(Replay(kMission), ElementsAre(LineOf(state)));
  Open();
  EXPECT_THAT(*journal_->ListMissions(), ElementsAre(kMission));
  EXPECT_THAT(Replay(kMission), ElementsAre(LineOf(state)));
}

TEST_P(DurableJournalConformance, ADeletedMissionLeavesItsNameAndNothingElse) {
  Open();
  Write(kMission, MakeSmallMission());
  Write("other", Blanks(1, 2));
  ASSERT_TRUE(journal_->PutPicture(kMission, Picture(1), 1 << 20).ok());
  ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  EXPECT_THAT(*journal_->ListMissions(), ElementsAre("other"));
  EXPECT_THAT(Replay(kMission), IsEmpty());
  Open();
  EXPECT_THAT(*journal_->ListMissions(), ElementsAre("other"));
  Write(kMission, Blanks(1, 1));
  EXPECT_THAT(PicturesOf(*journal_, kMission), IsEmpty());
  Open();
  EXPECT_EQ(Replay(kMission), LinesOf(Blanks(1, 1)));
  EXPECT_EQ(Replay("other"), LinesOf(Blanks(1, 2)));
}

TEST_P(DurableJournalConformance, AMissionThatIsAsideIsLeftAloneUntilItIsRead) {
  Open();
  const std::string summary("a summary\0 of bytes", 19);
  Write(kMission, Blanks(1, 3));
  EXPECT_TRUE(absl::IsNotFound(journal_->ReadSummary(kMission).status()));
  journal_->TidyUp(kMission);
  ASSERT_TRUE(journal_->PutAside(kMission, summary).ok());
  EXPECT_EQ(journal_->ReadSummary(kMission).value_or(""), summary);
  EXPECT_TRUE(absl::IsUnavailable(journal_->Append(kMission, Blank(4)).status()));
  EXPECT_GT(journal_->DiskBytes(kMission), 0u);
  EXPECT_TRUE(journal_->Damage(kMission).ok());
  Open();
  EXPECT_THAT(*journal_->ListMissions(), ElementsAre(kMission));
  EXPECT_EQ(journal_->ReadSummary(kMission).value_or(""), summary) << "it outlives the process";
  EXPECT_GT(journal_->DiskBytes(kMission), 0u);
  EXPECT_EQ(Replay(kMission), LinesOf(Blanks(1, 3)));
  EXPECT_TRUE(absl::IsNotFound(journal_->ReadSummary(kMission).status()));
  Write(kMission, Blanks(4, 4));
  ASSERT_TRUE(journal_->PutAside(kMission, "another").ok());
  ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  EXPECT_THAT(*journal_->ListMissions(), IsEmpty());
}

TEST_P(JournalConformance, KeepsTheFirstPictureOfAKeyframeAndTheNewestOfAMission) {
  Open();
  Write(kMission, Blanks(1, 4));
  for (const uint32_t i : {3u, 1u, 2u, 4u}) {
    ASSERT_TRUE(journal_->PutPicture(kMission, Picture(i), 3500).ok());
  }
  ASSERT_TRUE(journal_->PutPicture(kMission, Picture(4, 500), 3500).ok());
  EXPECT_TRUE(absl::IsNotFound(journal_->ReadPicture(kMission, {{7}, 3}).status()));
  const auto picture = journal_->ReadPicture(kMission, {{7}, 4});
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(picture->jpeg, Picture(4).jpeg);
  EXPECT_EQ(picture->scale, 4);
  Write(kMission, {Removal(5, 2)});
  EXPECT_TRUE(absl::IsNotFound(journal_->ReadPicture(kMission, {{7}, 2}).status()));
  if (!journal_->KeepsRecords()) return;
  EXPECT_THAT(PicturesOf(*journal_, kMission), ElementsAre(1u, 4u));
  Open();
  EXPECT_EQ(Replay(kMission).size(), 5u);
  EXPECT_THAT(PicturesOf(*journal_, kMission), ElementsAre(1u, 4u));
  ASSERT_TRUE(journal_->PutPicture(kMission, Picture(6), 2500).ok());
  EXPECT_THAT(PicturesOf(*journal_, kMission), ElementsAre(4u, 6u));
}

TEST_P(DurableJournalConformance, RemembersMissionsByLists) {
  Open();
  const MissionIdentity a{"a", "a-0123456789abcdef"};
  const MissionIdentity any{"b", ""};
  EXPECT_THAT(journal_->ReadList(MissionList::kDeleted), IsEmpty());
  ASSERT_TRUE(journal_->NoteInList(MissionList::kDeleted, any).ok());
  ASSERT_TRUE(journal_->NoteInList(MissionList::kPromised, any).ok());
  EXPECT_THAT(journal_->ReadList(MissionList::kDeleted), ElementsAre(any));
  Open();
  ASSERT_TRUE(journal_->NoteInList(MissionList::kPromised, any).ok());
  EXPECT_THAT(journal_->ReadList(MissionList::kDeleted), ElementsAre(any));
  EXPECT_THAT(journal_->ReadList(MissionList::kPromised), ElementsAre(any, any));
}

TEST_P(JournalConformance, TakesManyMissionsFromManyThreads) {
  Open();
  constexpr int kMissions = 4;
  constexpr int kThreadsEach = 2;
  constexpr uint64_t kRecords = 40;
  std::atomic<int> failed = 0;
  std::vector<std::thread> threads;
  // Records of one mission are appended one at a time, and many wait for them.
  std::vector<absl::Mutex> turns(kMissions);
  for (int i = 0; i < kMissions * kThreadsEach; ++i) {
    threads.emplace_back([&, i] {
      const std::string mission = absl::StrCat("m", i % kMissions);
      const uint64_t local_map = 100 + static_cast<uint64_t>(i);
      for (uint64_t number = 1; number <= kRecords; ++number) {
        absl::StatusOr<Journal::Position> appended;
        {
          absl::MutexLock turn(&turns[static_cast<size_t>(i % kMissions)]);
          appended = journal_->Append(mission, Blank(number, 5, local_map));
        }
        if (!appended.ok() || !journal_->Sync(mission, *appended).ok()) ++failed;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failed, 0);
  if (!journal_->KeepsRecords()) return;
  Open();
  for (int i = 0; i < kMissions; ++i) {
    EXPECT_EQ(Replay(absl::StrCat("m", i)).size(), kThreadsEach * kRecords) << i;
  }
}

TEST_P(DurableJournalConformance, WhatWasSyncedOutlivesAPowerCut) {
  Open();
  Write(kMission, Blanks(1, 5));
  ASSERT_TRUE(journal_->CreateMission("made", MakeFeatureMission("made", 3, kFeatures)).ok());
  ASSERT_TRUE(journal_->NoteInList(MissionList::kDeleted, {"x", ""}).ok());
  Write("deleted", Blanks(1, 2));
  ASSERT_TRUE(journal_->DeleteMission("deleted").ok());
  ASSERT_TRUE(journal_->Append(kMission, Blank(6)).ok());
  place_->LosePower();
  Open();
  std::vector<std::string> lines = Replay(kMission);
  ASSERT_GE(lines.size(), 5u);
  lines.resize(5);  // The sixth may be there.
  EXPECT_EQ(lines, LinesOf(Blanks(1, 5)));
  EXPECT_EQ(Replay("made").size(), 1u);
  EXPECT_THAT(Replay("deleted"), IsEmpty());
  EXPECT_EQ(journal_->ReadList(MissionList::kDeleted).size(), 1u);
}

TEST_P(DurableJournalConformance, DamageIsFoundAndIsOneMissionsAlone) {
  Open();
  Write(kMission, Blanks(1, 9));
  Write("other", Blanks(1, 2));
  journal_.reset();
  place_->Spoil(kMission);
  Open();
  const std::vector<std::string> lines = Replay(kMission);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], AllOf(HasSubstr("DATA_LOSS"), HasSubstr("journal")));
  EXPECT_TRUE(absl::IsDataLoss(journal_->Damage(kMission)));
  EXPECT_TRUE(absl::IsDataLoss(journal_->Append(kMission, Blank(10)).status()));
  EXPECT_FALSE(journal_->WantsSnapshot(kMission));
  EXPECT_TRUE(journal_->CheckWritable().ok());
  EXPECT_THAT(*journal_->ListMissions(), ::testing::UnorderedElementsAre(kMission, "other"));
  EXPECT_EQ(Replay("other"), LinesOf(Blanks(1, 2)));
  Write("other", Blanks(3, 3));
  ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  EXPECT_TRUE(journal_->Damage(kMission).ok());
  Write(kMission, Blanks(1, 1));
}

// A store on the journal, opened again, is what it was, with snapshots and without; asleep or not.
TEST_P(DurableJournalConformance, AStoreOpenedAgainIsWhatItWas) {
  Open();
  for (const uint64_t between_snapshots : {kNoSnapshots, uint64_t{1}}) {
    const std::string mission = absl::StrCat("m", between_snapshots);
    const SyntheticMap map = MakeRingMap(0xa, 0, 14);
    map_store::MapStoreOptions options = DeterministicOptions();
    options.sleep_after_s = 600;
    const auto open = [&] {
      Open(between_snapshots);
      auto store =
          std::make_unique<MapStore>(options, TheWorld().vocabulary, std::move(journal_), nullptr);
      EXPECT_TRUE(store->Recover().ok());
      return store;
    };
    std::unique_ptr<MapStore> store = open();
    TestAgent robot(*store, mission, "robot", map);
    ASSERT_TRUE(robot.Stream().ok());
    ASSERT_TRUE(robot.Close().ok());
    store->CloseSession(robot.session());
    const std::string local = DumpLocal(mission, *store);
    ASSERT_TRUE(store->SleepMission(mission).ok());
    EXPECT_EQ(DumpLocal(mission, *store), local);
    store.reset();
    store = open();
    EXPECT_EQ(DumpLocal(mission, *store), local) << between_snapshots;
  }
}

}  // namespace corbslam::testing
