#include "services/programs/robot/robot_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"
#include "client_agent/source_checks/testing/damage.h"
#include "client_agent/source_checks/testing/layered_scene.h"

namespace corbslam::services {

using client_agent::Damage;
using client_agent::FrameReader;
using client_agent::FrameStream;
using client_agent::KindSettings;
using client_agent::LayeredStereo;
using client_agent::LeftOutFrames;
using client_agent::NextFrame;
using client_agent::NoFrameYet;
using client_agent::ParseSourceSpec;
using client_agent::ReadFrame;
using client_agent::RegisterSourceKind;
using client_agent::SampleSource;
using client_agent::SharedKindSettings;
using client_agent::StreamFrame;

namespace {

using ::testing::HasSubstr;

int times_opened = 0;

// Gives a pair with its pictures the wrong way round.
class ExchangedPair : public FrameStream {
 public:
  const SensorCalibration& calibration() const override { return scene_.calibration; }
  std::optional<double> interval_s() const override { return 0.05; }
  absl::StatusOr<NextFrame> Next(absl::Time /*deadline*/) override {
    StreamFrame frame;
    frame.frame = {next_, static_cast<int64_t>(next_) * 50'000'000, 0};
    auto images = read_(next_++);
    if (!images.ok()) return images.status();
    frame.images = *std::move(images);
    return frame;
  }
  LeftOutFrames left_out() const override { return {}; }

 private:
  const SampleSource scene_ = LayeredStereo();
  const ReadFrame read_ = Damage(scene_.read, "exchanged");
  size_t next_ = 0;
};

// A camera that notes when somebody starts it, and refuses the place "wrong".
class TestCamera : public KindSettings {
 public:
  explicit TestCamera(std::string place) : place_(std::move(place)) {}
  absl::string_view kind() const override { return "testcamera"; }
  std::vector<absl::string_view> OptionNames() const override { return {"trust_calibration"}; }
  absl::StatusOr<SharedKindSettings> With(absl::string_view, absl::string_view) const override {
    auto trusting = std::make_shared<TestCamera>(*this);
    trusting->trusts_ = true;
    return trusting;
  }
  absl::Status Validate() const override { return absl::OkStatus(); }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override { return {}; }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool is_live() const override { return true; }
  bool trusts_calibration() const override { return trusts_; }
  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return absl::InvalidArgumentError("is live");
  }
  absl::Status CheckLive() const override {
    return place_ == "wrong" ? absl::InvalidArgumentError("no rig") : absl::OkStatus();
  }
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& /*stop*/) const override {
    ++times_opened;
    if (place_ == "exchanged") return std::make_unique<ExchangedPair>();
    return absl::UnavailableError("no such device");
  }

 private:
  std::string place_;
  bool trusts_ = false;
};

class RobotSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    times_opened = 0;
    RegisterSourceKind({"testcamera", "testcamera:PLACE",
                        [](absl::string_view place) -> absl::StatusOr<SharedKindSettings> {
                          return std::make_shared<TestCamera>(std::string(place));
                        }});
  }
};

TEST_F(RobotSourceTest, ACheckLeavesTheCameraAlone) {
  EXPECT_TRUE(CheckRobotSource(*ParseSourceSpec("testcamera:front"), false).ok());
  EXPECT_EQ(CheckRobotSource(*ParseSourceSpec("testcamera:wrong"), false).message(), "no rig");
  EXPECT_EQ(times_opened, 0);
  const absl::Notification never;
  EXPECT_EQ(OpenRobotSource(*ParseSourceSpec("testcamera:front"), false, never).status().message(),
            "no such device");
  EXPECT_EQ(times_opened, 1);
}

TEST_F(RobotSourceTest, ACheckRefusesToSelectACamerasFrames) {
  const auto spec = ParseSourceSpec("testcamera:front?frames=0:5");
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_THAT(CheckRobotSource(*spec, false).message(), HasSubstr("are of recordings"));
  EXPECT_EQ(times_opened, 0);
}

TEST_F(RobotSourceTest, ALivePairIsJudgedBeforeItIsPlayed) {
  const absl::Notification never;
  const auto refused = OpenRobotSource(*ParseSourceSpec("testcamera:exchanged"), false, never);
  ASSERT_TRUE(refused.ok()) << refused.status();
  absl::StatusOr<NextFrame> next = NoFrameYet();
  while (next.ok() && std::holds_alternative<NoFrameYet>(*next)) {
    next = refused->stream->Next(absl::InfiniteFuture());
  }
  EXPECT_THAT(std::string(next.status().message()), HasSubstr("[pair-exchanged]"));
  const auto trusted =
      OpenRobotSource(*ParseSourceSpec("testcamera:exchanged?trust-calibration"), false, never);
  ASSERT_TRUE(trusted.ok()) << trusted.status();
  next = NoFrameYet();
  while (next.ok() && std::holds_alternative<NoFrameYet>(*next)) {
    next = trusted->stream->Next(absl::InfiniteFuture());
  }
  EXPECT_TRUE(next.ok()) << next.status();
}

TEST_F(RobotSourceTest, AnUnknownOptionOfACameraListsNoneOfRecordings) {
  const std::string told(ParseSourceSpec("testcamera:front?scale=0.5").status().message());
  EXPECT_THAT(told, HasSubstr("known are trust_calibration"));
}

TEST_F(RobotSourceTest, ARecordingIsOpenedToCheckIt) {
  EXPECT_FALSE(CheckRobotSource(*ParseSourceSpec("kitti:/nowhere"), false).ok());
}

}  // namespace
}  // namespace corbslam::services
