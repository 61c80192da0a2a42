// Tests that nothing that is set from afar, or that a file has of it, ends a robot.
#include "services/programs/live_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/programs/kept_settings.h"
#include "services/programs/robot_flag_checks.h"
#include "services/programs/robot_flags.h"
#include "services/security/robot_settings_signature.h"
#include "services/security/testing/token_keys.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMiB = uint64_t{1} << 20;

std::string MaskPng(int width, int height) {
  cv::Mat mask(height, width, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, width / 4, height / 4)) = 0;
  std::vector<uchar> png;
  cv::imencode(".png", mask, png);
  return {png.begin(), png.end()};
}

class LiveSettingsTest : public ::testing::Test {
 protected:
  LiveSettingsTest() {
    std::filesystem::remove(kept_);
    std::ofstream(key_) << keys_.public_pem;
    flags_.server = "127.0.0.1:1";
    flags_.width_px = 640;
    flags_.height_px = 480;
  }

  v1::RobotSettings Settings(uint64_t version) const {
    v1::RobotSettings settings;
    settings.set_mission("missions/lab");
    settings.set_agent("alpha");
    settings.set_version(version);
    return settings;
  }
  v1::RobotSettingsList Sign(const v1::RobotSettings& settings) const {
    v1::RobotSettingsList list;
    const auto made = SignRobotSettings(settings, keys_.private_pem);
    EXPECT_TRUE(made.ok()) << made.status();
    if (made.ok()) *list.add_settings() = *made;
    return list;
  }
  // Makes those of a process of the robot that starts.
  std::unique_ptr<LiveSettings> Start() {
    orders_ = std::make_shared<client_agent::AgentOrders>();
    Camera camera;
    camera.width_px = flags_.width_px;
    camera.height_px = flags_.height_px;
    orders_->SetCamera(camera);
    const RobotFlags flags = flags_;
    return std::make_unique<LiveSettings>(LiveSettingsOptions{
        .files = {.key = key_, .kept = kept_},
        .mission = "lab",
        .agent = "alpha",
        .flags = flags,
        .given = flags.given,
        .orders = orders_,
        .rate = std::make_shared<FrameRateLimit>(),
        .check = [flags](const SettableFlags& set) { return CheckSettable(With(set, flags)); },
        .limits =
            [](const SettableFlags&, const SettableFlags& set) {
              return client_agent::ChangedLimits{.share = ScopeOf(set, /*is_bounded=*/false)};
            }});
  }
  static std::string Refused(const LiveSettings& live) { return live.Report()["refused"].dump(); }

  const test_data::TokenKeys keys_ = test_data::MakeTokenKeys();
  const std::string name_ = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const std::string key_ = absl::StrCat(::testing::TempDir(), "/corbslam_live_", name_, ".pem");
  const std::string kept_ = absl::StrCat(::testing::TempDir(), "/corbslam_live_", name_, ".kept");
  RobotFlags flags_;
  std::shared_ptr<client_agent::AgentOrders> orders_;
};

struct Case {
  const char* what;
  std::function<void(RobotFlags&)> own;            // Of the robot.
  std::function<void(v1::RobotSettings&)> change;  // What it can't run with.
  const char* says;
};

// Each is signed by the owner, and within the bounds of what any robot can run with.
const std::vector<Case>& CasesThatDontFit() {
  static const auto& cases = *new std::vector<Case>{
      {"a budget too small for its pictures",
       [](RobotFlags& own) { own.width_px = 4000, own.height_px = 3000; },
       [](v1::RobotSettings& set) { set.set_memory_budget_bytes(300 * kMiB); },
       "pictures of 4000x3000"},
      {"a budget too small for its outbox",
       [](RobotFlags& own) { own.outbox_mb = 1000, own.given = {"--outbox-mb"}; },
       [](v1::RobotSettings& set) { set.set_memory_budget_bytes(500 * kMiB); },
       "1000 MiB for --outbox-mb"},
      {"a budget, though its own flags have all come",
       [](RobotFlags& own) { own.share = ShareMode::kEverything, own.given = {"--share"}; },
       [](v1::RobotSettings& set) { set.set_memory_budget_bytes(500 * kMiB); },
       "--share everything has no bound"},
      {"features that its own budget has no room for",
       [](RobotFlags& own) {
         own.memory_budget_bytes = 300 * kMiB, own.given = {"--memory-budget"};
       },
       [](v1::RobotSettings& set) { set.set_features(20'000); }, "20000 features"},
      {"a radius without what it is of", [](RobotFlags&) {},
       [](v1::RobotSettings& set) { set.set_share_radius_m(20); }, "needs --share nearby"},
      {"nothing for one that lives of others' map",
       [](RobotFlags& own) { own.localise_only = true; },
       [](v1::RobotSettings& set) { set.set_share("none"); },
       "--localise-only needs others' keyframes"},
      {"a mask of another size", [](RobotFlags&) {},
       [](v1::RobotSettings& set) { set.set_mask_png(MaskPng(320, 240)); }, "expected 640x480"},
  };
  return cases;
}

TEST_F(LiveSettingsTest, WhatDoesNotFitLeavesARobotAsItWasAlsoAtItsNextStart) {
  for (const Case& one : CasesThatDontFit()) {
    SCOPED_TRACE(one.what);
    std::filesystem::remove(kept_);
    flags_ = RobotFlags();
    flags_.server = "127.0.0.1:1";
    flags_.width_px = 640;
    flags_.height_px = 480;
    one.own(flags_);
    v1::RobotSettings good = Settings(1);
    good.set_max_frame_rate_hz(12);
    v1::RobotSettings bad = Settings(2);
    bad.set_max_frame_rate_hz(3);
    one.change(bad);
    const auto live = Start();
    EXPECT_EQ(live->Begin(Sign(good)).max_rate_hz, 12);
    live->OnSettings(Sign(bad));
    EXPECT_THAT(Refused(*live), HasSubstr(one.says));
    EXPECT_EQ(live->Report()["version_of_robot"], 1);
    // The next process reaches the store, or not: both begin as this one goes on.
    const auto with_store = Start();
    EXPECT_EQ(with_store->Begin(Sign(bad)).max_rate_hz, 12);
    EXPECT_THAT(Refused(*with_store), HasSubstr(one.says));
    const auto alone = Start();
    EXPECT_EQ(alone->Begin(absl::UnavailableError("away")).max_rate_hz, 12);
    EXPECT_THAT(Refused(*alone), HasSubstr(one.says));
    // One whose flags changed since begins without, and says so, too.
    v1::RobotSettings better = Settings(3);
    better.set_max_frame_rate_hz(9);
    live->OnSettings(Sign(better));
    EXPECT_EQ(Start()->Begin(absl::UnavailableError("away")).max_rate_hz, 9);
  }
}

TEST_F(LiveSettingsTest, AFileThatIsDamagedIsToldAndEndsNothing) {
  std::ofstream(kept_).close();
  const auto live = Start();
  EXPECT_EQ(live->Begin(v1::RobotSettingsList()).max_rate_hz, 0);
  EXPECT_THAT(Refused(*live), HasSubstr("is empty"));
  v1::RobotSettings settings = Settings(4);
  settings.set_max_frame_rate_hz(5);
  live->OnSettings(Sign(settings));
  EXPECT_EQ(ReadKeptSettings(kept_)->settings_size(), 1);
}

TEST_F(LiveSettingsTest, AKeyThatCannotBeReadIsReadWhenItComes) {
  std::filesystem::remove(key_);
  const auto live = Start();
  v1::RobotSettings settings = Settings(4);
  settings.set_max_frame_rate_hz(5);
  EXPECT_EQ(live->Begin(Sign(settings)).max_rate_hz, 0);
  EXPECT_THAT(Refused(*live), HasSubstr(key_));
  std::ofstream(key_) << keys_.public_pem;
  live->OnSettings(Sign(settings));
  EXPECT_EQ(live->Report()["version_of_robot"], 4);
}

TEST_F(LiveSettingsTest, AMaskThatFitsIsTaken) {
  v1::RobotSettings settings = Settings(1);
  settings.set_mask_png(MaskPng(640, 480));
  const auto live = Start();
  EXPECT_FALSE(live->Begin(Sign(settings)).mask_png.empty());
  EXPECT_EQ(Refused(*live), "[]");
  live->GiveMask();
  EXPECT_TRUE(orders_->Take().mask.has_value());
}

}  // namespace
}  // namespace corbslam::services
