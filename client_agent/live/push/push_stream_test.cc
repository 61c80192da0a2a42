// A robot's stream and the library of drivers, with each other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/live/push/push_camera.h"
#include "client_agent/live/push/push_source.h"
#include "client_agent/live/push/testing/push_packets.h"
#include "client_agent/push_client/corbslam/push.hpp"
#include "client_agent/source/rig/rig_file.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr int kPatience_ms = 20000;

class PushStreamTest : public ::testing::Test {
 protected:
  PushStreamTest() {
    RegisterPushSource();
    char folder[] = "/tmp/push_test_XXXXXX";
    folder_ = mkdtemp(folder);
    path_ = folder_ + "/camera.sock";
  }
  ~PushStreamTest() override {
    stream_.reset();
    std::filesystem::remove_all(folder_);
  }

  absl::StatusOr<std::unique_ptr<FrameStream>> Open(const std::string& options = "") {
    const auto spec = ParseSourceSpec(absl::StrCat("push:", path_, options));
    if (!spec.ok()) return spec.status();
    return spec->settings->OpenLive(stop_);
  }
  // The robot has the rig's file.
  void OpenWithRig() {
    std::ofstream(folder_ + "/rig.yaml") << kSmallRig;
    auto opened = Open("?rig=" + folder_ + "/rig.yaml");
    ASSERT_TRUE(opened.ok()) << opened.status();
    stream_ = *std::move(opened);
  }
  corbslam_push_options Options(const char* rig = nullptr) const {
    corbslam_push_options options = {};
    options.socket_path = path_.c_str();
    options.rig_text = rig;
    options.name = "test";
    options.first = {CORBSLAM_PUSH_GREY8, 64, 48, 0};
    options.second = options.first;
    options.slots = 2;
    options.timeout_ms = kPatience_ms;
    return options;
  }
  static void Push(PushConnection& driver, int grey, int64_t time_ns) {
    const auto slot = driver.Begin(kPatience_ms);
    ASSERT_TRUE(slot.has_value());
    std::memset(slot->first, grey, 64 * 48);
    std::memset(slot->second, grey + 1, 64 * 48);
    driver.Commit(*slot, time_ns);
  }
  StreamFrame Next() {
    auto next = stream_->Next(absl::Now() + absl::Milliseconds(kPatience_ms));
    EXPECT_TRUE(next.ok() && std::holds_alternative<StreamFrame>(*next));
    if (!next.ok() || !std::holds_alternative<StreamFrame>(*next)) return {};
    return std::get<StreamFrame>(*std::move(next));
  }
  static std::string WhyNot(const corbslam_push_options& options) {
    try {
      const PushConnection connection(options);
    } catch (const PushError& error) {
      return absl::StrCat(corbslam_push_status_name(error.status()), ": ", error.what());
    }
    return "connected";
  }

  std::string folder_;
  std::string path_;
  absl::Notification stop_;
  std::unique_ptr<FrameStream> stream_;
};

// A frame has one time: what a calibration says beside it must not part its pictures.
TEST_F(PushStreamTest, ARigsTimeOffsetDoesNotStarveIt) {
  std::string rig = kSmallRig;
  const size_t end = rig.rfind('}');
  ASSERT_NE(end, std::string::npos);
  rig.insert(end, ", time_offset_s: 0.0001");
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  PushConnection driver(Options(rig.c_str()));
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  Push(driver, 40, 1000);
  EXPECT_EQ(Next().frame.timestamp_ns, 1000);
  ASSERT_EQ(stream_->findings().size(), 1u);
  EXPECT_EQ(stream_->findings()[0].code, "time-offset-unused");
}

TEST_F(PushStreamTest, OneCameraGivesOnePicture) {
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  corbslam_push_options options = Options(kOneCameraRig);
  options.second = {};
  PushConnection driver(options);
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  EXPECT_EQ(KindOf(stream_->calibration()), SensorKind::kMonocular);
  const auto slot = driver.Begin(kPatience_ms);
  ASSERT_TRUE(slot.has_value());
  EXPECT_EQ(slot->second, nullptr);
  std::memset(slot->first, 40, 64 * 48);
  driver.Commit(*slot, 1000);
  const StreamFrame frame = Next();
  EXPECT_EQ(frame.frame.timestamp_ns, 1000);
  EXPECT_EQ(frame.images.grey.at<uint8_t>(5, 5), 40);
  EXPECT_TRUE(frame.images.right.empty());
  EXPECT_TRUE(frame.images.depth.empty());
}

std::vector<int64_t> MeasuredAt(const StreamFrame& frame) {
  std::vector<int64_t> times_ns;
  for (const ImuSample& sample : frame.images.imu) times_ns.push_back(sample.timestamp_ns);
  return times_ns;
}

// The rig says that its stamps are 2 ns too early.
TEST_F(PushStreamTest, FramesComeWithWhatAnImuMeasured) {
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  const std::string rig = SmallRigWithImu();
  PushConnection driver(Options(rig.c_str()));
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  EXPECT_TRUE(std::get<StereoCalibration>(stream_->calibration()).imu.has_value());
  const corbslam_push_imu_sample two[] = {{990, {0.1, 0.2, 0.3}, {0, 0, 9.8}},
                                          {1000, {0.4, 0.5, 0.6}, {0, 0, 9.7}}};
  EXPECT_TRUE(driver.PushImu(two, 2));
  Push(driver, 40, 1001);
  const StreamFrame first = Next();
  EXPECT_EQ(MeasuredAt(first), (std::vector<int64_t>{992, 1002}));
  EXPECT_EQ(first.images.imu[1].angular_velocity_rps, Eigen::Vector3d(0.4, 0.5, 0.6));
  EXPECT_EQ(first.images.imu[1].specific_force_mps2, Eigen::Vector3d(0, 0, 9.7));
  // A frame that a newer one replaces loses no samples.
  EXPECT_TRUE(driver.PushImu({1010, {}, {0, 0, 9.8}}));
  Push(driver, 50, 1012);
  EXPECT_TRUE(driver.PushImu({1020, {}, {0, 0, 9.8}}));
  Push(driver, 60, 1022);
  // The robot has read all, as it has given back both slots.
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(driver.Begin(kPatience_ms).has_value());
  const StreamFrame second = Next();
  EXPECT_EQ(second.frame.timestamp_ns, 1022);
  EXPECT_EQ(MeasuredAt(second), (std::vector<int64_t>{1012, 1022}));
}

TEST_F(PushStreamTest, TheLibraryFindsWrongSamplesBeforeItSendsThem) {
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  const std::string rig = SmallRigWithImu();
  PushConnection driver(Options(rig.c_str()));
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  const auto says = [&](const corbslam_push_imu_sample& sample) {
    try {
      driver.PushImu(sample);
    } catch (const PushError& error) {
      return absl::StrCat(corbslam_push_status_name(error.status()), ": ", error.what());
    }
    return std::string("sent");
  };
  EXPECT_EQ(says({100, {}, {}}), "sent");
  EXPECT_THAT(says({100, {}, {}}), HasSubstr("invalid: timestamp_ns of a sample is 100, the one"));
  EXPECT_THAT(says({int64_t{1} << 61, {}, {}}), HasSubstr("more than a minute ahead"));
  EXPECT_THAT(says({200, {std::nan(""), 0, 0}, {}}), HasSubstr("no finite number"));
  EXPECT_THAT(says({200, {}, {0, 0, HUGE_VAL}}), HasSubstr("no finite number"));
  EXPECT_EQ(says({200, {}, {}}), "sent") << "the connection stands";
  Push(driver, 40, 200);
  EXPECT_EQ(MeasuredAt(Next()), (std::vector<int64_t>{102, 202}));
}

TEST_F(PushStreamTest, ADriverHearsThatTheRobotTakesNoSamples) {
  OpenWithRig();
  PushConnection driver(Options());
  try {
    driver.PushImu({100, {}, {}});
    FAIL() << "samples were taken";
  } catch (const PushError& error) {
    EXPECT_EQ(error.status(), CORBSLAM_PUSH_INVALID);
    EXPECT_THAT(error.what(), HasSubstr("its rig has no block imu:"));
  }
  // Frames are.
  Push(driver, 40, 1000);
  EXPECT_EQ(Next().frame.timestamp_ns, 1000);
}

TEST_F(PushStreamTest, PlaysADriverThatSaysItsRigAndTellsItPoses) {
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  PushConnection driver(Options(kSmallRig));
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  EXPECT_EQ(std::get<StereoCalibration>(stream_->calibration()).camera.width_px, 64);
  Push(driver, 40, 1000);
  const StreamFrame frame = Next();
  EXPECT_EQ(frame.frame.timestamp_ns, 1000);
  EXPECT_EQ(frame.images.grey.at<uint8_t>(47, 63), 40);
  EXPECT_EQ(frame.images.right.at<uint8_t>(47, 63), 41);

  EXPECT_FALSE(driver.NextPose(0).has_value());
  FramePose pose{.timestamp_ns = 1000, .local_map = {7}, .points_matched = 12, .dropped = 3};
  pose.local_from_camera = Rigid3d{Eigen::Quaterniond(0, 1, 0, 0), {1, 2, 3}};
  stream_->pose_listener()->OnPose(pose);
  auto told = driver.NextPose(kPatience_ms);
  ASSERT_TRUE(told.has_value());
  EXPECT_EQ(told->timestamp_ns, 1000);
  EXPECT_EQ(told->state, static_cast<uint32_t>(CORBSLAM_PUSH_TRACKING));
  EXPECT_EQ(told->local_map, 7u);
  EXPECT_EQ(told->dropped, 3u);
  EXPECT_EQ(told->points_matched, 12u);
  EXPECT_EQ(told->translation[2], 3);
  EXPECT_EQ(told->rotation[0], 1);
  stream_->pose_listener()->OnPose({.timestamp_ns = 1001, .is_lost = true});
  told = driver.NextPose(kPatience_ms);
  ASSERT_TRUE(told.has_value());
  EXPECT_EQ(told->state, static_cast<uint32_t>(CORBSLAM_PUSH_LOST));
}

TEST_F(PushStreamTest, PosesAreOfTheCameraAsItRecords) {
  // The right camera is turned about x, so that rectification turns both.
  std::string rig = kSmallRig;
  rig.replace(rig.find("rectified"), std::string::npos,
              "rectified: false\nright_from_left: [1, 0, 0, -0.1, 0, 0.9998, -0.02, 0, "
              "0, 0.02, 0.9998, 0, 0, 0, 0, 1]\n");
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  PushConnection driver(Options(rig.c_str()));
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  stream_->pose_listener()->OnPose({.timestamp_ns = 1, .local_from_camera = Rigid3d()});
  const auto told = driver.NextPose(kPatience_ms);
  ASSERT_TRUE(told.has_value());
  const auto recorded = RecordedCameraOf(stream_->calibration());
  ASSERT_TRUE(recorded.ok());
  const Eigen::Quaterniond turned(told->rotation);
  EXPECT_LT(turned.angularDistance(recorded->camera_from_recorded.rotation), 1e-9);
  EXPECT_GT(turned.angularDistance(Eigen::Quaterniond::Identity()), 1e-3);
}

TEST_F(PushStreamTest, ASlowRobotGetsTheNewestFrame) {
  OpenWithRig();
  PushConnection driver(Options());
  for (int i = 1; i <= 100; ++i) Push(driver, i, i);
  // The last slot is free once the last frame was copied.
  const auto one = driver.Begin(kPatience_ms);
  const auto two = driver.Begin(kPatience_ms);
  ASSERT_TRUE(one.has_value() && two.has_value());
  EXPECT_NE(one->index, two->index);
  EXPECT_EQ(Next().frame.timestamp_ns, 100);
  EXPECT_EQ(stream_->overtaken(), 99u);
  EXPECT_EQ(stream_->left_out().count, 0u);
}

TEST_F(PushStreamTest, ARobotThatTakesNothingLeavesNoSlotFree) {
  auto opened = PushCamera::Open({.path = path_, .rig = std::nullopt});
  ASSERT_TRUE(opened.ok());
  PushCamera& camera = **opened;
  auto waiting = std::async(std::launch::async, [&] { return camera.AwaitRig(stop_); });
  PushConnection driver(Options(kSmallRig));
  ASSERT_TRUE(waiting.get().ok());
  Push(driver, 1, 1);
  Push(driver, 2, 2);
  EXPECT_FALSE(driver.Begin(0).has_value());
  EXPECT_FALSE(driver.Begin(50).has_value());
  PicturePairing pairing(true, 0);
  ASSERT_TRUE(camera.Start(pairing).ok());
  EXPECT_TRUE(driver.Begin(kPatience_ms).has_value());
  EXPECT_TRUE(driver.Begin(kPatience_ms).has_value());
  EXPECT_EQ((*pairing.Take(absl::InfiniteFuture()))->first.timestamp_ns, 2);
  EXPECT_EQ(pairing.counts().overtaken, 1u);
  camera.Stop();
}

TEST_F(PushStreamTest, ADriverThatVanishesInMidFrameIsWaitedFor) {
  OpenWithRig();
  {
    PushConnection driver(Options());
    Push(driver, 1, 1);
    EXPECT_EQ(Next().frame.timestamp_ns, 1);
    const auto slot = driver.Begin(kPatience_ms);
    std::memset(slot->first, 99, 64 * 20);
  }
  auto next = stream_->Next(absl::Now() + absl::Milliseconds(200));
  ASSERT_TRUE(next.ok());
  EXPECT_TRUE(std::holds_alternative<NoFrameYet>(*next));
  PushConnection driver(Options());
  Push(driver, 2, 2);
  EXPECT_EQ(Next().images.grey.at<uint8_t>(0, 0), 2);
}

TEST_F(PushStreamTest, TheLastFramesOfADriverThatWentAreTaken) {
  OpenWithRig();
  for (int64_t i = 0; i < 20; ++i) {
    {
      PushConnection driver(Options());
      Push(driver, 10, 10 * i + 1);
      Push(driver, 20, 10 * i + 2);
    }
    StreamFrame frame = Next();
    if (frame.frame.timestamp_ns == 10 * i + 1) frame = Next();
    EXPECT_EQ(frame.frame.timestamp_ns, 10 * i + 2);
  }
}

TEST_F(PushStreamTest, ADriverMayPauseForTenSeconds) {
  OpenWithRig();
  PushConnection driver(Options());
  Push(driver, 1, 1);
  EXPECT_EQ(Next().frame.timestamp_ns, 1);
  EXPECT_FALSE(driver.NextPose(10000).has_value());
  Push(driver, 2, 10'000'000'001);
  EXPECT_EQ(Next().frame.timestamp_ns, 10'000'000'001);
}

TEST_F(PushStreamTest, SaysWhyADriverIsRefused) {
  OpenWithRig();
  corbslam_push_options options = Options();
  options.first.width_px = 32;
  EXPECT_THAT(WhyNot(options), HasSubstr("refused: first.width_px is 32, must be 64, the rig's"));
  options = Options();
  options.second.format = CORBSLAM_PUSH_DEPTH16;
  EXPECT_THAT(WhyNot(options), HasSubstr("refused: second.format is 4, must be 1"));
  options = Options();
  options.slots = 65;
  EXPECT_THAT(WhyNot(options), HasSubstr("invalid: slots is 65"));
  options = Options();
  options.first.stride_bytes = 10;
  EXPECT_THAT(WhyNot(options), HasSubstr("invalid: first.stride_bytes is 10"));
  PushConnection driver(Options());
  EXPECT_THAT(WhyNot(Options()), HasSubstr("refused: another driver is connected, 'test'"));
  // What is wrong in the library's own eyes ends nothing.
  Push(driver, 1, 5);
  const auto slot = driver.Begin(kPatience_ms);
  try {
    driver.Commit(*slot, 5);
    ADD_FAILURE() << "times must grow";
  } catch (const PushError& error) {
    EXPECT_EQ(error.status(), CORBSLAM_PUSH_INVALID);
    EXPECT_THAT(error.what(), HasSubstr("timestamp_ns is 5, the frame before has 5"));
  }
  driver.Commit(*slot, 6);
}

// One frame is stamped by CLOCK_REALTIME: it is refused, and no later one is.
TEST_F(PushStreamTest, AFrameOfAnotherClockIsRefusedAlone) {
  OpenWithRig();
  PushConnection driver(Options());
  Push(driver, 1, 5);
  EXPECT_EQ(Next().frame.timestamp_ns, 5);
  const auto slot = driver.Begin(kPatience_ms);
  try {
    driver.Commit(*slot, absl::GetCurrentTimeNanos());
    ADD_FAILURE() << "it is decades ahead";
  } catch (const PushError& error) {
    EXPECT_EQ(error.status(), CORBSLAM_PUSH_INVALID);
    EXPECT_THAT(error.what(), HasSubstr("more than a minute ahead of CLOCK_MONOTONIC"));
  }
  driver.Commit(*slot, 6);
  EXPECT_EQ(Next().frame.timestamp_ns, 6);
}

TEST_F(PushStreamTest, WaitsForARigThatIsOne) {
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  EXPECT_THAT(WhyNot(Options()), HasSubstr("refused: rig: the hello says none"));
  std::string rig = kSmallRig;
  rig.replace(rig.find("baseline_m: 0.1"), 15, "baseline_m: nan");
  EXPECT_THAT(WhyNot(Options(rig.c_str())), HasSubstr("baseline_m"));
  rig = kSmallRig;
  rig.replace(rig.find("baseline_m: 0.1"), 15, "baseline_m: 100");
  EXPECT_THAT(WhyNot(Options(rig.c_str())), HasSubstr("refused: the driver's rig"));
  {
    PushConnection driver(Options(kSmallRig));
    auto opened = opening.get();
    ASSERT_TRUE(opened.ok()) << opened.status();
    stream_ = *std::move(opened);
  }
  rig = kSmallRig;
  rig.replace(rig.find("baseline_m: 0.1"), 15, "baseline_m: 0.2");
  // The robot may not have seen yet that the first one went.
  std::string why = WhyNot(Options(rig.c_str()));
  for (int i = 0; i < 100 && why.find("another driver") != std::string::npos; ++i) {
    absl::SleepFor(absl::Milliseconds(20));
    why = WhyNot(Options(rig.c_str()));
  }
  EXPECT_THAT(why, HasSubstr("refused: rig: is another one"));
}

TEST_F(PushStreamTest, StopsWhileItWaitsForADriver) {
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  absl::SleepFor(absl::Milliseconds(50));
  stop_.Notify();
  EXPECT_TRUE(absl::IsCancelled(opening.get().status()));
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(PushStreamTest, ADriverHearsThatTheRobotWentOrIsNotThere) {
  corbslam_push_options options = Options();
  options.timeout_ms = 100;
  EXPECT_THAT(WhyNot(options), HasSubstr("gone: no robot listens at"));
  OpenWithRig();
  PushConnection driver(Options());
  stream_.reset();
  try {
    driver.NextPose(kPatience_ms);
    ADD_FAILURE() << "the robot went";
  } catch (const PushError& error) {
    EXPECT_EQ(error.status(), CORBSLAM_PUSH_GONE);
  }
}

TEST_F(PushStreamTest, OneThreadFollowsPosesWhileAnotherPushes) {
  OpenWithRig();
  PushConnection driver(Options());
  std::atomic<int> told = 0;
  std::thread follower([&] {
    for (; told < 200; ++told) {
      if (!driver.NextPose(kPatience_ms).has_value()) return;
    }
  });
  for (int i = 1; i <= 200; ++i) {
    Push(driver, i % 200, i);
    EXPECT_EQ(Next().frame.timestamp_ns, i);
    stream_->pose_listener()->OnPose({.timestamp_ns = i});
  }
  follower.join();
  EXPECT_EQ(told, 200);
}

TEST_F(PushStreamTest, TakesColourAndDepth) {
  std::string rig = kSmallRig;
  const size_t right = rig.find("  - {", rig.find("  - {") + 1);
  rig.replace(right, std::string::npos, "depth: {units_per_m: 5000}\n");
  rig.replace(rig.find("stereo"), 6, "rgbd");
  auto opening = std::async(std::launch::async, [this] { return Open(); });
  corbslam_push_options options = Options(rig.c_str());
  options.first = {CORBSLAM_PUSH_BGR8, 64, 48, 200};
  options.second = {CORBSLAM_PUSH_DEPTH16, 64, 48, 0};
  PushConnection driver(options);
  auto opened = opening.get();
  ASSERT_TRUE(opened.ok()) << opened.status();
  stream_ = *std::move(opened);
  const std::vector<std::array<uint8_t, 3>> green(64 * 48, {0, 200, 0});
  std::vector<uint16_t> depth(64 * 48, 1234);
  depth.back() = 65535;
  ASSERT_TRUE(driver.Push(green.data(), depth.data(), 1, kPatience_ms));
  const StreamFrame frame = Next();
  EXPECT_EQ(frame.images.grey.type(), CV_8UC1);
  EXPECT_NEAR(frame.images.grey.at<uint8_t>(47, 63), 0.587 * 200, 1);
  EXPECT_EQ(frame.images.depth.type(), CV_16UC1);
  EXPECT_EQ(frame.images.depth.at<uint16_t>(0, 0), 1234);
  EXPECT_EQ(frame.images.depth.at<uint16_t>(47, 63), 65535);
}

TEST_F(PushStreamTest, GreyOfSixteenBitsBecomesEight) {
  OpenWithRig();
  corbslam_push_options options = Options();
  options.first.format = CORBSLAM_PUSH_GREY16;
  PushConnection driver(options);
  std::vector<uint16_t> first(64 * 48, 0x8080);
  first[0] = 65535;
  const std::vector<uint8_t> second(64 * 48, 3);
  ASSERT_TRUE(driver.Push(first.data(), second.data(), 1, kPatience_ms));
  const StreamFrame frame = Next();
  EXPECT_EQ(frame.images.grey.at<uint8_t>(0, 0), 255);
  EXPECT_EQ(frame.images.grey.at<uint8_t>(47, 63), 0x80);
  EXPECT_EQ(frame.images.right.at<uint8_t>(47, 63), 3);
}

// A camera of 12 bits, whose driver pushes what it measured: a sixteenth of what 16 bits would be.
TEST_F(PushStreamTest, GreyOfTwelveBitsIsNotTakenForDark) {
  OpenWithRig();
  corbslam_push_options options = Options();
  options.first.format = CORBSLAM_PUSH_GREY16;
  options.second.format = CORBSLAM_PUSH_GREY16;
  PushConnection driver(options);
  std::vector<uint16_t> first(64 * 48, 0x800);
  std::fill_n(first.begin(), 64, 0xfff);
  const std::vector<uint16_t> second(64 * 48, 0x400);
  ASSERT_TRUE(driver.Push(first.data(), second.data(), 1, kPatience_ms));
  const StreamFrame frame = Next();
  EXPECT_EQ(frame.images.grey.at<uint8_t>(0, 0), 255);
  EXPECT_EQ(frame.images.grey.at<uint8_t>(47, 63), 0x80);
  EXPECT_EQ(frame.images.right.at<uint8_t>(47, 63), 0x40) << "both cameras are scaled alike";
}

TEST_F(PushStreamTest, ChecksWithoutWaiting) {
  const auto check = [&](const std::string& text) {
    const auto spec = ParseSourceSpec(text);
    return spec.ok() ? spec->settings->CheckLive() : spec.status();
  };
  EXPECT_TRUE(check("push:" + path_).ok());
  EXPECT_FALSE(check("push:").ok());
  EXPECT_THAT(std::string(check("push:" + path_ + "?rig=/nowhere.yaml").message()),
              HasSubstr("/nowhere.yaml"));
  EXPECT_THAT(std::string(check("push:" + path_ + "?pair-within-ms=3").message()),
              HasSubstr("pair"));
}

}  // namespace
}  // namespace corbslam::client_agent
