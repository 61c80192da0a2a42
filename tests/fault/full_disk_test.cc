// Tests a real map store whose disk runs full under a robot's stream, and one whose disk can't be
// written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/health_client.h"
#include "services/client/store/store_reader.h"
#include "tests/fault/disk/small_disk.h"
#include "tests/fault/fault_fixture.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::CheckHealth;
using services::ChildProcess;
using services::ConnectToStore;
using services::StoreReader;
using services::WithoutTls;

namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr char kMission[] = "narrow";
constexpr uint64_t kMiB = 1 << 20;
// The disk is too small for what the database would like to reserve for its log.
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
    // The switch is off until SwitchToReadOnly.
    StartWith({{"LD_PRELOAD", CORBSLAM_READ_ONLY_SWITCH}, {"CORBSLAM_TEST_DISK", disk_->folder()}});
    store_ = Start(name, "map_store",
                   {"--listen", address_.empty() ? "127.0.0.1:0" : address_, "--data-dir",
                    disk_->folder() + "/data", "--min-free-mb", absl::StrCat(min_free_mb),
                    "--in-process-worker", "--keep-everything"});
    StartWith({});
    address_ = AddressOf(store_.get());
    ASSERT_FALSE(address_.empty());
    const auto channel = ConnectToStore(address_, WithoutTls());
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

// A robot maps; the disk takes nothing for a while, then it does again.
struct Refusal {
  std::string name;
  int min_free_mb = 0;
  std::string code;  // What the robot is told.
  absl::Status (*begin)(SmallDisk&);
  absl::Status (*end)(SmallDisk&);
};

// One robot's drive is under way when the disk refuses (or at its end: that is up to the machine),
// another one's begins then.
class RefusalTest : public FullDiskTest, public ::testing::WithParamInterface<Refusal> {
 protected:
  void StartRobot(const std::string& name) {
    robots_[name] = Start(name, "client_agent",
                          {"--source", absl::StrCat(DemoSource(), "?stride=2"), "--server",
                           address_, "--mission", kMission, "--agent", name, "--pace", "sensor",
                           "--stats", FileOf(name + ".json"), "--finish", "300"});
    ASSERT_NE(robots_[name], nullptr);
  }
  // Expects that look-ups go on, the robot waits, and nothing is stored in part.
  void ExpectPatience(const std::string& name) {
    EXPECT_TRUE(Becomes([&] { return !IsReady(); })) << ReadText(LogOf("store"));
    EXPECT_TRUE(CheckHealth(channel_, "liveness").ok()) << "a restart would not help";
    EXPECT_TRUE(Becomes([&] {
      return ReadText(LogOf(name)).find(GetParam().code) != std::string::npos;
    })) << ReadText(LogOf(name));
    stored_ = StoredKeyframes();
    absl::SleepFor(absl::Seconds(3));
    EXPECT_EQ(StoredKeyframes(), stored_);
    EXPECT_FALSE(robots_[name]->end().has_value());
    EXPECT_FALSE(store_->end().has_value());
  }
  void ExpectEverythingOnce() {
    EXPECT_TRUE(Becomes([&] { return IsReady(); })) << ReadText(LogOf("store"));
    uint64_t keyframes = 0;
    for (const auto& [name, robot] : robots_) {
      ASSERT_TRUE(robot->WaitForEnd(absl::Seconds(120)));
      EXPECT_TRUE(robot->EndStatus().ok()) << robot->EndStatus();
      const json own = ReadStatistics(FileOf(name + ".json"));
      ASSERT_TRUE(own.is_object());
      keyframes += own["keyframes"].get<uint64_t>();
      const auto frames = reader_->CountReportedFrames();
      ASSERT_TRUE(frames.ok()) << frames.status();
      EXPECT_EQ(frames->at(name), own["tracked"].get<uint64_t>() + own["lost"].get<uint64_t>());
    }
    EXPECT_GT(keyframes, stored_);
    EXPECT_EQ(StoredKeyframes(), keyframes);
    stored_ = keyframes;
  }

  std::map<std::string, std::unique_ptr<ChildProcess>> robots_;
  uint64_t stored_ = 0;
};

TEST_P(RefusalTest, RobotsWaitAndGoOnOnceTheDiskTakesRecordsAgain) {
  ASSERT_NO_FATAL_FAILURE(StartStore("store", GetParam().min_free_mb));
  EXPECT_TRUE(IsReady());
  ASSERT_NO_FATAL_FAILURE(StartRobot("alpha"));
  ASSERT_TRUE(Becomes([&] { return StoredKeyframes() > 0; }));
  ASSERT_TRUE(GetParam().begin(*disk_).ok()) << GetParam().begin(*disk_);
  ASSERT_NO_FATAL_FAILURE(StartRobot("beta"));
  ASSERT_NO_FATAL_FAILURE(ExpectPatience("beta"));
  ASSERT_TRUE(GetParam().end(*disk_).ok());
  ASSERT_NO_FATAL_FAILURE(ExpectEverythingOnce());
  // What the store has was written, because a new process has it, too.
  store_->Stop(absl::ZeroDuration());
  ASSERT_NO_FATAL_FAILURE(StartStore("store_again", GetParam().min_free_mb));
  EXPECT_EQ(StoredKeyframes(), stored_);
}

INSTANTIATE_TEST_SUITE_P(Disks, RefusalTest,
                         ::testing::Values(
                             // The store sees that its reserve would be touched.
                             Refusal{"FullButForItsReserve", 8, "RESOURCE_EXHAUSTED",
                                     [](SmallDisk& disk) { return disk.Fill(0); },
                                     [](SmallDisk& disk) { return disk.Empty(); }},
                             // The store sees that there is no room at all.
                             Refusal{"Full", 0, "RESOURCE_EXHAUSTED",
                                     [](SmallDisk& disk) { return disk.Fill(0); },
                                     [](SmallDisk& disk) { return disk.Empty(); }},
                             Refusal{"ReadOnly", 8, "UNAVAILABLE",
                                     [](SmallDisk& disk) { return disk.SwitchReadOnly(true); },
                                     [](SmallDisk& disk) { return disk.SwitchReadOnly(false); }}),
                         [](const auto& info) { return info.param.name; });

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
}  // namespace corbslam::tests
