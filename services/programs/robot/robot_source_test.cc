#include "services/programs/robot/robot_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"

namespace corbslam::services {

using client_agent::FrameReader;
using client_agent::FrameStream;
using client_agent::KindSettings;
using client_agent::ParseSourceSpec;
using client_agent::RegisterSourceKind;
using client_agent::SharedKindSettings;

namespace {

using ::testing::HasSubstr;

int times_opened = 0;

// A camera that notes when somebody starts it, and refuses the place "wrong".
class TestCamera : public KindSettings {
 public:
  explicit TestCamera(std::string place) : place_(std::move(place)) {}
  absl::string_view kind() const override { return "testcamera"; }
  std::vector<absl::string_view> OptionNames() const override { return {}; }
  absl::StatusOr<SharedKindSettings> With(absl::string_view, absl::string_view) const override {
    return absl::InvalidArgumentError("has no options");
  }
  absl::Status Validate() const override { return absl::OkStatus(); }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override { return {}; }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool is_live() const override { return true; }
  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return absl::InvalidArgumentError("is live");
  }
  absl::Status CheckLive() const override {
    return place_ == "wrong" ? absl::InvalidArgumentError("no rig") : absl::OkStatus();
  }
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& /*stop*/) const override {
    ++times_opened;
    return absl::UnavailableError("no such device");
  }

 private:
  std::string place_;
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

TEST_F(RobotSourceTest, ARecordingIsOpenedToCheckIt) {
  EXPECT_FALSE(CheckRobotSource(*ParseSourceSpec("kitti:/nowhere"), false).ok());
}

}  // namespace
}  // namespace corbslam::services
