// What is held back when a process is killed, and what the next one makes of it.
#include "client_agent/upload/held_back_items.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "absl/time/time.h"
#include "client_agent/spool/testing/fake_spool.h"
#include "client_agent/upload/spooled_map_reading.h"
#include "client_agent/upload/update_recorder.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kHolding{7};
constexpr uint32_t kHeldBackKeypoints = 10;

// What a robot maps and holds back, and the spool that keeps it.
class HeldBackDrive {
 public:
  explicit HeldBackDrive(const SpoolOptions& options = {})
      : spool_(*OpenFakeSpool(&disk_, options)) {
    map_.SetObserver(&recorder_);
  }
  // Its spool has segments of this size, and a thread that syncs when it is told to.
  explicit HeldBackDrive(uint64_t segment_bytes) : HeldBackDrive(SyncedWhenTold(segment_bytes)) {}

  static SpoolOptions SyncedWhenTold(uint64_t segment_bytes) {
    SpoolOptions options;
    options.segment_bytes = segment_bytes;
    options.sync = SyncPolicy{.after = absl::Hours(1), .bytes = 1 << 30};
    return options;
  }
  // All is told, and nothing held back any more.
  void End() {
    recorder_.StopHoldingBack();
    WriteBatch();
    writer_.Finish(*spool_);
  }
  Spool& spool() { return *spool_; }
  FakeDisk& disk() { return disk_; }

  // A keyframe that sees a new point, and the point of the one before.
  void AddKeyframe(uint32_t index) {
    Features features;
    features.keypoints.resize(kHeldBackKeypoints);
    features.descriptors.resize(kHeldBackKeypoints);
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload({kHolding, index}, index, 0, testing::TestCamera(),
                                           std::move(features));
    if (index > 0) keyframe.parent = {kHolding, index - 1};
    map_.AddKeyframe(keyframe);
    MapPoint point;
    point.id = {kHolding, index};
    point.reference = {kHolding, index};
    point.position_in_map = {0, 0, 5};
    point.normal_in_map = {0, 0, 1};
    map_.AddPoint(point);
    map_.AddObservation(point.id, point.reference, 0);
    if (index > 0) map_.AddObservation({kHolding, index - 1}, {kHolding, index}, 1);
    recorder_.AddTrackedFrame({index, {kHolding, index}, {}});
  }
  void WriteBatch() {
    MapUpdateBatch batch = recorder_.TakeBatch(map_, 100);
    batch.number = ++last_;
    ASSERT_TRUE(spool_->Append(batch).ok());
  }
  void WriteHeldBack() {
    const absl::Status written = writer_.Write(recorder_.CopyHeldBack(map_), last_, *spool_);
    ASSERT_TRUE(written.ok()) << written;
  }
  // Returns the keyframes of the local map that the next process has.
  static std::set<uint32_t> KeyframesAfter(FakeDisk disk) {
    const auto spool = *OpenFakeSpool(&disk);
    EXPECT_TRUE(TellHeldBack(*spool).ok());
    const absl::StatusOr<SpooledMap> spooled_map = ReadNewestSpooledMap(*spool);
    std::set<uint32_t> keyframes;
    if (!spooled_map.ok()) return keyframes;
    for (const auto& [id, keyframe] : spooled_map->keyframes()) keyframes.insert(id.index);
    return keyframes;
  }

 protected:
  FakeDisk disk_;
  std::unique_ptr<Spool> spool_;
  Map map_;
  // All but the first are held back.
  UpdateRecorder recorder_{kHolding, RecorderOptions{.hold_newest = 100}};
  HeldBackWriter writer_;
  uint64_t last_ = 0;
};

class HeldBackItemsTest : public ::testing::Test, protected HeldBackDrive {};

TEST_F(HeldBackItemsTest, WhatIsHeldBackIsThereAfterTheProcess) {
  for (uint32_t i = 0; i < 5; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  const auto spool = *OpenFakeSpool(&disk_);
  ASSERT_TRUE(TellHeldBack(*spool).ok());
  const absl::StatusOr<SpooledMap> spooled_map = ReadNewestSpooledMap(*spool);
  ASSERT_TRUE(spooled_map.ok()) << spooled_map.status();
  EXPECT_EQ(spooled_map->keyframes().size(), 5u);
  EXPECT_EQ(spooled_map->points().size(), 5u);
  EXPECT_EQ(spooled_map->newest_ns(), 4);
  for (uint32_t i = 1; i < 5; ++i) {
    const auto& seen = spooled_map->observations().keyframes().at({kHolding, i});
    EXPECT_EQ(seen[0], (MapPointId{kHolding, i}));
    EXPECT_EQ(seen[1], (MapPointId{kHolding, i - 1}));
    EXPECT_EQ(spooled_map->keyframes().at({kHolding, i}).parent, (KeyframeId{kHolding, i - 1}));
  }
}

TEST_F(HeldBackItemsTest, WhatWasToldMeanwhileIsNotToldAgain) {
  for (uint32_t i = 0; i < 5; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  recorder_.StopHoldingBack();
  WriteBatch();
  const auto spool = *OpenFakeSpool(&disk_);
  ASSERT_TRUE(TellHeldBack(*spool).ok());
  EXPECT_EQ(spool->found().size(), 2u) << "the two batches";
  EXPECT_TRUE(ReadNewestSpooledMap(*spool).ok());
  EXPECT_EQ(KeyframesAfter(disk_).size(), 5u);
}

// The process may end between a batch and the next record of what is held back.
TEST_F(HeldBackItemsTest, WhatABatchDidNotTellIsStillThere) {
  for (uint32_t i = 0; i < 5; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  map_.RemoveKeyframe({kHolding, 2});
  recorder_.StopHoldingBack();
  MapUpdateBatch batch = recorder_.TakeBatch(map_, 1);
  ASSERT_EQ(batch.full_keyframes.size(), 1u);
  ASSERT_EQ(batch.full_keyframes[0].payload->id.index, 1u);
  batch.number = ++last_;
  ASSERT_TRUE(spool_->Append(batch).ok());
  EXPECT_EQ(KeyframesAfter(disk_), (std::set<uint32_t>{0, 1, 3, 4}));
}

TEST_F(HeldBackItemsTest, APayloadIsWrittenOnce) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  AddKeyframe(3);
  const HeldBackItems held_back = recorder_.CopyHeldBack(map_);
  ASSERT_EQ(held_back.keyframes.size(), 1u);
  EXPECT_EQ(held_back.keyframes[0].payload->id.index, 3u);
  EXPECT_EQ(held_back.rest.light_keyframes.size(), 3u);
  recorder_.CopyHeldBackAnew();
  EXPECT_EQ(recorder_.CopyHeldBack(map_).keyframes.size(), 3u);
}

TEST_F(HeldBackItemsTest, WhatMappingTookOutIsGone) {
  for (uint32_t i = 0; i < 5; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  map_.RemoveKeyframe({kHolding, 3});
  WriteHeldBack();
  EXPECT_EQ(KeyframesAfter(disk_), (std::set<uint32_t>{0, 1, 2, 4}));
}

// Whatever byte of the last records the disk did not keep: the map before is there, and it is a
// whole one.
TEST_F(HeldBackItemsTest, ATornTailLeavesWhatWasThereBefore) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  const std::string name = disk_.files.begin()->first;
  const size_t before = disk_.files[name].size();
  AddKeyframe(3);
  WriteHeldBack();
  const std::string whole = disk_.files[name];
  ASSERT_GT(whole.size(), before);
  for (size_t size = before; size < whole.size(); ++size) {
    FakeDisk cut = disk_;
    cut.files[name] = whole.substr(0, size);
    // The fake codec looks batches up in the disk that it was made for.
    ASSERT_EQ(KeyframesAfter(cut), (std::set<uint32_t>{0, 1, 2})) << "cut at " << size;
  }
  EXPECT_EQ(KeyframesAfter(disk_).size(), 4u);
}

TEST_F(HeldBackItemsTest, ItIsToldOnceOverTwoRestarts) {
  for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i);
  WriteBatch();
  WriteHeldBack();
  size_t records = 0;
  for (int restart = 0; restart < 2; ++restart) {
    const auto spool = *OpenFakeSpool(&disk_);
    ASSERT_TRUE(TellHeldBack(*spool).ok());
    if (restart == 0) records = spool->found().size();
    EXPECT_EQ(spool->found().size(), records);
  }
  EXPECT_EQ(KeyframesAfter(disk_).size(), 4u);
}

TEST_F(HeldBackItemsTest, ThingsThatAreNotThereAreSaid) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  WriteBatch();
  HeldBackItems held_back = recorder_.CopyHeldBack(map_);
  held_back.keyframes.clear();
  ASSERT_TRUE(writer_.Write(held_back, last_, *spool_).ok());
  const auto spool = *OpenFakeSpool(&disk_);
  EXPECT_TRUE(absl::IsDataLoss(TellHeldBack(*spool)));
  EXPECT_EQ(spool->found().size(), 1u) << "the batch is there";
}

// A process that is killed right after the store has acknowledged the end leaves what was put off.
TEST(HeldBackWriterTest, OfALocalMapThatHasEndedNothingIsToldAgain) {
  HeldBackDrive drive(uint64_t{1});
  for (uint32_t i = 0; i < 5; ++i) drive.AddKeyframe(i);
  drive.WriteBatch();
  drive.WriteHeldBack();
  drive.End();
  {
    const auto spool = *OpenFakeSpool(&drive.disk());
    for (const SpooledBatch& found : spool->TakeFound()) {
      if (found.record.kind == SpoolRecord::Kind::kBatch) spool->Release(found);
    }
  }
  const auto spool = *OpenFakeSpool(&drive.disk());
  ASSERT_FALSE(spool->found().empty()) << "the test can't tell";
  EXPECT_TRUE(TellHeldBack(*spool).ok());
  EXPECT_TRUE(spool->found().empty());
}

// A local map ends: what was held back is in its last batches, which the disk has not got yet.
TEST(HeldBackWriterTest, ALossOfPowerTakesNothingWhenALocalMapEnds) {
  std::mt19937 random(5);
  int without_the_end = 0;
  for (int cut = 0; cut < 40; ++cut) {
    HeldBackDrive drive(cut % 2 == 0 ? uint64_t{1} : uint64_t{1} << 20);
    for (uint32_t i = 0; i < 5; ++i) drive.AddKeyframe(i);
    drive.WriteBatch();
    drive.WriteHeldBack();
    ASSERT_TRUE(drive.spool().Sync().ok());
    drive.End();
    FakeDisk after = drive.disk();
    after.CutPower(random);
    const std::set<uint32_t> keyframes = HeldBackDrive::KeyframesAfter(after);
    EXPECT_EQ(keyframes.size(), 5u) << "cut " << cut;
    without_the_end += after.Used() < drive.disk().Used() ? 1 : 0;
    // Once the disk has the batches, what was held back goes.
    ASSERT_TRUE(drive.spool().Sync().ok());
    const auto next = *OpenFakeSpool(&drive.disk());
    for (const SpooledBatch& left : next->found()) {
      const bool shares_a_segment = cut % 2 != 0;
      EXPECT_TRUE(left.record.kind == SpoolRecord::Kind::kBatch || shares_a_segment);
    }
  }
  EXPECT_GT(without_the_end, 0) << "the test can't tell";
}

}  // namespace
}  // namespace corbslam::client_agent
