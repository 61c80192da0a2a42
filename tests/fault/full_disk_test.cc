// A real map store whose disk runs full under a robot's stream, and one whose disk can't be
// written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/corbslam/store_reader.h"
#include "services/remote/channel.h"
#include "services/testing/health_client.h"
#include "tests/fault/disk/small_disk.h"
#include "tests/fault/fault_fixture.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr char kMission[] = "narrow";
constexpr uint64_t kMiB = 1 << 20;
// Too small for what the database would like to reserve for its log: each record needs room anew.
constexpr uint64_t kDiskBytes = 48 * kMiB;

class FullDiskTest : public FaultTest {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(FileOf("disk"));
    auto disk = SmallDisk::Mount(FileOf("disk"), kDiskBytes);
    SKIP_UNLESS_PERMITTED(disk.status());
    disk_ = *std::move(disk);
  }

  void StartStore(const std::string& name, int min_free_mb) {
    store_ = Start(name, "map_store",
                   {"--listen", address_.empty() ? "127.0.0.1:0" : address_, "--data-dir",
                    disk_->folder() + "/data", "--min-free-mb", absl::StrCat(min_free_mb),
                    "--in-process-worker"});
    address_ = AddressOf(store_.get());
    ASSERT_FALSE(address_.empty());
    const auto channel = ConnectToStore(address_, grpc::InsecureChannelCredentials());
    ASSERT_TRUE(channel.ok()) << channel.status();
    channel_ = *channel;
    reader_ = std::make_unique<StoreReader>(channel_, kMission);
  }

  uint64_t StoredKeyframes() {
    const auto statistics = reader_->Statistics();
    return statistics.ok() ? statistics->mission().keyframes() : 0;
  }
  template <typename Condition>
  static bool Becomes(Condition condition, absl::Duration patience = absl::Seconds(60)) {
    const absl::Time deadline = absl::Now() + patience;
    while (!condition() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(50));
    return condition();
  }
  bool IsReady() { return CheckHealth(channel_, "readiness").ok(); }

  std::unique_ptr<SmallDisk> disk_;
  std::unique_ptr<ChildProcess> store_;
  std::string address_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<StoreReader> reader_;
};

// With a reserve that the store does not touch, in MiB.
class ReserveTest : public FullDiskTest, public ::testing::WithParamInterface<int> {};

TEST_P(ReserveTest, RobotsWaitAndGoOnOnceThereIsRoom) {
  ASSERT_NO_FATAL_FAILURE(StartStore("store", GetParam()));
  EXPECT_TRUE(IsReady());
  const auto robot = Start("alpha", "client_agent",
                           {"--source", absl::StrCat(DemoSource(), "?stride=2"), "--server",
                            address_, "--mission", kMission, "--agent", "alpha", "--pace", "sensor",
                            "--stats", FileOf("alpha.json"), "--finish", "300"});
  ASSERT_NE(robot, nullptr);
  ASSERT_TRUE(Becomes([&] { return StoredKeyframes() > 0; }));

  ASSERT_TRUE(disk_->Fill(0).ok()) << disk_->Fill(0);
  EXPECT_TRUE(Becomes([&] { return !IsReady(); }));
  EXPECT_TRUE(CheckHealth(channel_, "liveness").ok()) << "a restart would not help";
  EXPECT_TRUE(Becomes([&] {
    const std::string log = ReadText(LogOf("alpha"));
    return log.find("RESOURCE_EXHAUSTED") != std::string::npos;
  })) << ReadText(LogOf("alpha"));
  // Look-ups go on, the robot waits, and nothing is stored in part.
  const uint64_t stored = StoredKeyframes();
  absl::SleepFor(absl::Seconds(3));
  EXPECT_EQ(StoredKeyframes(), stored);
  EXPECT_FALSE(robot->end().has_value());
  EXPECT_FALSE(store_->end().has_value());

  ASSERT_TRUE(disk_->Empty().ok());
  EXPECT_TRUE(Becomes([&] { return IsReady(); }));
  ASSERT_TRUE(robot->WaitForEnd(absl::Seconds(120)));
  EXPECT_TRUE(robot->EndStatus().ok()) << robot->EndStatus();
  const json own = ReadStatistics(FileOf("alpha.json"));
  ASSERT_TRUE(own.is_object());
  const auto keyframes = own["keyframes"].get<uint64_t>();
  EXPECT_GT(keyframes, stored);
  EXPECT_EQ(StoredKeyframes(), keyframes);
  const auto frames = reader_->CountReportedFrames();
  ASSERT_TRUE(frames.ok()) << frames.status();
  EXPECT_EQ(frames->at("alpha"), own["tracked"].get<uint64_t>() + own["lost"].get<uint64_t>());

  // And it was written: a new process has it.
  store_->Stop(absl::ZeroDuration());
  ASSERT_NO_FATAL_FAILURE(StartStore("store_again", GetParam()));
  EXPECT_EQ(StoredKeyframes(), keyframes);
}

INSTANTIATE_TEST_SUITE_P(MinFreeMb, ReserveTest, ::testing::Values(8));

TEST_F(FullDiskTest, AStoreThatCantWriteRefusesToStartByName) {
  ASSERT_TRUE(disk_->MakeReadOnly().ok());
  const auto store = Start(
      "store", "map_store",
      {"--listen", "127.0.0.1:0", "--data-dir", disk_->folder() + "/data", "--in-process-worker"});
  ASSERT_NE(store, nullptr);
  ASSERT_TRUE(store->WaitForEnd(absl::Seconds(60)));
  EXPECT_EQ(store->end()->exit_code, 1);
  const std::string log = ReadText(LogOf("store"));
  EXPECT_THAT(log, HasSubstr("FAILED_PRECONDITION"));
  EXPECT_THAT(log, HasSubstr(disk_->folder()));
}

}  // namespace
}  // namespace corbslam
