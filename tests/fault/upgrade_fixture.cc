#include "tests/fault/upgrade_fixture.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::ConnectToStore;
using services::ServedTrajectory;
using services::StoreReader;
using services::WithoutTls;

namespace {

// Frames are stored as floats beside their keyframe, which may move once more in the end.
constexpr double kSamePlace_m = 0.005;
// Files of trajectories have microseconds.
constexpr int64_t kMicrosecond_ns = 1000;

std::string ProgramsOf(Build build) {
  const char* old = std::getenv("CORBSLAM_OLD_PROGRAMS");
  return build == Build::kOld && old != nullptr ? old : CORBSLAM_PROGRAMS_DIR;
}

int64_t Microseconds(int64_t timestamp_ns) {
  return (timestamp_ns + kMicrosecond_ns / 2) / kMicrosecond_ns;
}

// Returns the poses of FILE, FILE.2 and so on.
Trajectory ReadPoses(const std::string& file) {
  Trajectory poses;
  for (int part = 1;; ++part) {
    const std::string path = part == 1 ? file : absl::StrCat(file, ".", part);
    if (!std::filesystem::exists(path)) return poses;
    const auto read = ReadTumTrajectory(path);
    EXPECT_TRUE(read.ok()) << read.status();
    if (read.ok()) poses.insert(poses.end(), read->begin(), read->end());
  }
}

}  // namespace

bool HasOldPrograms() { return std::getenv("CORBSLAM_OLD_PROGRAMS") != nullptr; }

std::unique_ptr<ChildProcess> UpgradeTest::StartOf(Build build, const std::string& name,
                                                   const std::string& program,
                                                   std::vector<std::string> arguments) {
  StartFrom(ProgramsOf(build));
  return Start(name, program, std::move(arguments));
}

bool UpgradeTest::Knows(Build build, const std::string& program, const std::string& flag) {
  const std::string name = absl::StrCat("help", starts_++);
  StartFrom(ProgramsOf(build));
  const auto help = Start(name, program, {"--help"}, /*security=*/{});
  if (help == nullptr) return false;
  EXPECT_TRUE(help->WaitForEnd(absl::Seconds(30)));
  return absl::StrContains(ReadText(LogOf(name)), flag);
}

void UpgradeTest::StartWorker(Build build) {
  const std::string listen = worker_address_.empty() ? "127.0.0.1:0" : worker_address_;
  worker_ =
      StartOf(build, absl::StrCat("worker", starts_++), "fusion_worker", {"--listen", listen});
  worker_address_ = AddressOf(worker_.get());
  ASSERT_NE(worker_address_, "");
}

void UpgradeTest::StartStore(Build build) {
  const std::string listen = store_address_.empty() ? "127.0.0.1:0" : store_address_;
  std::vector<std::string> arguments = {"--listen",      listen,       "--worker",
                                        worker_address_, "--data-dir", FileOf("data")};
  // Keyframes are counted.
  if (Knows(build, "map_store", "--keep-everything")) arguments.push_back("--keep-everything");
  store_ = StartOf(build, absl::StrCat("store", starts_++), "map_store", std::move(arguments));
  store_address_ = AddressOf(store_.get());
  ASSERT_NE(store_address_, "");
}

void UpgradeTest::End(std::unique_ptr<ChildProcess>& process) {
  process->Stop(absl::Seconds(60));
  EXPECT_TRUE(process->EndStatus().ok()) << process->EndStatus();
  process.reset();
}

void UpgradeTest::StartRobot(Build build, const std::string& agent, const std::string& options,
                             const std::vector<std::string>& flags) {
  const std::string source = WantsLongFaults() ? LongSource() : DemoSource();
  Robot robot{agent, absl::StrCat(agent, starts_++), nullptr};
  std::vector<std::string> arguments = {"--source",     absl::StrCat(source, "?", options),
                                        "--server",     store_address_,
                                        "--agent",      agent,
                                        "--mission",    kMission,
                                        "--stats",      FileOf(robot.name + ".json"),
                                        "--trajectory", FileOf(robot.name + ".tum"),
                                        "--pace",       "sensor"};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  robot.process = StartOf(build, robot.name, "client_agent", std::move(arguments));
  ASSERT_NE(robot.process, nullptr);
  robots_.push_back(std::move(robot));
}

UpgradeTest::Robot* UpgradeTest::Newest(const std::string& agent) {
  const auto it = std::find_if(robots_.rbegin(), robots_.rend(),
                               [&](const Robot& robot) { return robot.agent == agent; });
  return it == robots_.rend() ? nullptr : &*it;
}

void UpgradeTest::EndRobot(const std::string& agent) {
  Robot* const robot = Newest(agent);
  ASSERT_NE(robot, nullptr);
  robot->process->Stop(absl::Seconds(120));
  EXPECT_TRUE(robot->process->EndStatus().ok()) << robot->process->EndStatus();
}

absl::Status UpgradeTest::WaitForRobot(const std::string& agent) {
  Robot* const robot = Newest(agent);
  if (robot == nullptr) return absl::NotFoundError(agent);
  if (robot->process->WaitForEnd(absl::Seconds(180))) return robot->process->EndStatus();
  return absl::DeadlineExceededError(absl::StrCat(robot->name, " still runs after 180 s"));
}

std::map<std::string, uint64_t> UpgradeTest::WaitForFrames(
    const std::map<std::string, uint64_t>& before) {
  StoreReader reader = Reader();
  const absl::Time deadline = absl::Now() + absl::Seconds(120);
  std::map<std::string, uint64_t> frames;
  while (absl::Now() < deadline) {
    frames = reader.CountReportedFrames().value_or(frames);
    const bool all = std::all_of(robots_.begin(), robots_.end(), [&](const Robot& robot) {
      const auto old = before.find(robot.agent);
      return robot.process->end().has_value() ||
             frames[robot.agent] > (old == before.end() ? 0 : old->second);
    });
    if (all) return frames;
    absl::SleepFor(absl::Milliseconds(50));
  }
  ADD_FAILURE() << "no further frames came within 120 s";
  return frames;
}

StoreReader UpgradeTest::Reader() {
  const auto channel = ConnectToStore(store_address_, WithoutTls());
  EXPECT_TRUE(channel.ok()) << channel.status();
  return StoreReader(channel.ok() ? *channel : services::MakeChannel(store_address_), kMission);
}

std::vector<RobotAccount> UpgradeTest::Accounts() const {
  std::vector<RobotAccount> accounts;
  for (const Robot& robot : robots_) {
    const nlohmann::json own = ReadStatistics(FileOf(robot.name + ".json"));
    EXPECT_TRUE(own.is_object()) << robot.name;
    if (!own.is_object()) continue;
    accounts.push_back({robot.agent, own["keyframes"].get<uint64_t>(),
                        own["tracked"].get<uint64_t>() + own["lost"].get<uint64_t>(),
                        own["outbox"]["batches"].get<uint64_t>(),
                        own["outbox"]["lost_local_maps"].get<uint64_t>(),
                        ReadPoses(FileOf(robot.name + ".tum"))});
  }
  return accounts;
}

void UpgradeTest::ExpectPosesStored(const RobotAccount& account) {
  // Older robots do not say where the recorded camera is.
  const auto stored =
      Reader().ReadTrajectory(account.agent, v1::TRAJECTORY_FRAME_LOCAL, PosesOf::kRectifiedCamera);
  ASSERT_TRUE(stored.ok()) << stored.status();
  std::multimap<int64_t, Eigen::Vector3d> places;
  for (const services::ServedPose& pose : *stored) {
    places.emplace(Microseconds(pose.timestamp_ns), pose.frame_from_camera.translation);
  }
  size_t absent = 0;
  double farthest = 0;
  for (const StampedPose& pose : account.poses) {
    // A robot may have seen the same picture in two drives.
    double nearest = std::numeric_limits<double>::infinity();
    const auto [begin, end] = places.equal_range(Microseconds(pose.timestamp_ns));
    for (auto it = begin; it != end; ++it) {
      nearest = std::min(nearest, (it->second - pose.world_from_camera.translation).norm());
    }
    if (begin == end) ++absent;
    if (begin != end) farthest = std::max(farthest, nearest);
  }
  EXPECT_EQ(absent, 0u) << account.agent << ", of " << account.poses.size() << " poses";
  EXPECT_LT(farthest, kSamePlace_m) << account.agent;
}

void UpgradeTest::ExpectNothingLost(size_t robots) {
  StoreReader reader = Reader();
  const absl::Status fused = reader.WaitUntilFused(absl::Seconds(300));
  EXPECT_TRUE(fused.ok()) << fused;
  uint64_t keyframes = 0;
  std::map<std::string, uint64_t> frames;
  std::map<std::string, uint64_t> batches_left;
  for (const RobotAccount& account : Accounts()) {
    batches_left[account.agent] = account.batches_left;
    EXPECT_EQ(account.local_maps_lost, 0u) << account.agent;
    EXPECT_GT(account.keyframes, 0u) << account.agent;
    keyframes += account.keyframes;
    frames[account.agent] += account.frames;
    ExpectPosesStored(account);
    std::printf("%s: %lu keyframes, %lu frames, %zu poses\n", account.agent.c_str(),
                static_cast<unsigned long>(account.keyframes),
                static_cast<unsigned long>(account.frames), account.poses.size());
  }
  for (const auto& [agent, batches] : batches_left) EXPECT_EQ(batches, 0u) << agent;
  const auto stored = reader.CountReportedFrames();
  ASSERT_TRUE(stored.ok()) << stored.status();
  EXPECT_EQ(*stored, frames);
  const auto statistics = reader.Statistics();
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_EQ(statistics->mission().keyframes(), keyframes);
  ASSERT_EQ(statistics->mission().islands_size(), 1);
  EXPECT_EQ(statistics->mission().islands(0).agents_size(), static_cast<int>(robots));
  EXPECT_EQ(statistics->mission().failed_requests(), 0u);
  std::printf("the store: %lu keyframes\n",
              static_cast<unsigned long>(statistics->mission().keyframes()));
}

}  // namespace corbslam::tests
