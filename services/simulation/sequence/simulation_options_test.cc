#include "services/simulation/sequence/simulation_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Holds a value that is not the default for every option there is.
const std::map<std::string, std::string> kOthers = {{"seed", "7"},
                                                    {"world", "12345678901234"},
                                                    {"length", "812.3456789"},
                                                    {"poses", "/data/00.txt"},
                                                    {"around", "room"},
                                                    {"rooms", "5x2"},
                                                    {"look_alike", "1"},
                                                    {"moving_cars", "12"},
                                                    {"rig", "euroc"},
                                                    {"motion", "fly"},
                                                    {"rate", "15"},
                                                    {"picture_scale", "0.5"},
                                                    {"phase", "0.5"},
                                                    {"turned", "1"},
                                                    {"start_s", "3600"},
                                                    {"blackout", "10.5:2"},
                                                    {"kidnap", "20:5"},
                                                    {"beginning", "1:2:3.5"},
                                                    {"set_off_s", "2.5"},
                                                    {"hand", "12:1.5"},
                                                    {"exposure_steps", "5:0.3/8:1/11.5:4"},
                                                    {"exposure", "1.3"},
                                                    {"exposure_drift", "0.25"},
                                                    {"blur_px", "0.123456789012"},
                                                    {"rolling_shutter_ms", "12.5"},
                                                    {"depth_aside_m", "0.05"},
                                                    {"imu", "phone"},
                                                    {"imu_rate", "400"},
                                                    {"imu_bias", "0.02:0.3"},
                                                    {"imu_late_s", "-0.005"},
                                                    {"imu_vibration", "92.5:0.1:5"},
                                                    {"imu_warming", "0.01:0.2:60"},
                                                    {"imu_range", "4:20"},
                                                    {"imu_gaps", "5:0.2/9.5:1"},
                                                    {"noise_seed", "99"},
                                                    {"epipolar_error_px", "0.31"},
                                                    {"disparity_error_px", "-0.11"},
                                                    {"scale_error", "0.0123"},
                                                    {"truth_error_m", "0.2"},
                                                    {"truth_error_deg", "0.5"},
                                                    {"threads", "2"}};

TEST(SimulationOptionsTest, EveryOptionComesBackAsWritten) {
  for (const absl::string_view name : SimulationOptionNames()) {
    ASSERT_TRUE(kOthers.contains(std::string(name))) << name << " is not tested";
    const std::string& value = kOthers.at(std::string(name));
    SimulationSpec spec;
    ASSERT_TRUE(ApplySimulationOption(name, value, spec).ok()) << name;
    const auto texts = FormatSimulationOptions(spec);
    ASSERT_EQ(texts.size(), 1u) << name;
    EXPECT_EQ(texts[0].first, name);
    EXPECT_EQ(texts[0].second, value);
  }
  EXPECT_THAT(FormatSimulationOptions({}), IsEmpty());
}

TEST(SimulationOptionsTest, NamesWhatItCannotTake) {
  for (const auto& [name, value] : {std::pair<const char*, const char*>{"seed", "-1"},
                                    {"length", "far"},
                                    {"rig", "gopro"},
                                    {"motion", "swim"},
                                    {"blackout", "10"},
                                    {"kidnap", "a:b"},
                                    {"rooms", "4"},
                                    {"turned", "2"},
                                    {"poses", ""},
                                    {"imu", "best"},
                                    {"imu_bias", "0.1"},
                                    {"imu_gaps", "3:1/4"},
                                    {"threads", "1.5"}}) {
    SimulationSpec spec;
    const absl::Status status = ApplySimulationOption(name, value, spec);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr(std::string(name) + "=" + value));
    EXPECT_THAT(FormatSimulationOptions(spec), IsEmpty()) << name;
  }
}

TEST(SimulationSpecTest, RefusesWhatCannotBe) {
  for (const auto& [name, value] : {std::pair<const char*, const char*>{"length", "3"},
                                    {"phase", "1.5"},
                                    {"poses", "x.txt"},
                                    {"rate", "-3"},
                                    {"picture_scale", "0"},
                                    {"scale_error", "nan"},
                                    {"truth_error_deg", "-1"},
                                    {"blur_px", "11"},
                                    {"kidnap", "2:-1"},
                                    {"set_off_s", "-1"},
                                    {"imu_rate", "5"},
                                    {"imu_bias", "0.1:-1"},
                                    {"imu_gaps", "3:nan"},
                                    {"exposure_steps", "3:0.5/2:1"},
                                    {"threads", "0"}}) {
    SimulationSpec spec;
    ASSERT_TRUE(ApplySimulationOption(name, value, spec).ok()) << name;
    const absl::Status status = Validate(spec);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr(name));
  }
  SimulationSpec without_poses;
  without_poses.world = SimulatedWorld::kPath;
  EXPECT_THAT(std::string(Validate(without_poses).message()), HasSubstr("poses"));
}

TEST(SimulationSpecTest, TheWorldIsNotWhatTheRobotDoes) {
  SimulationSpec spec;
  const std::string world = WorldName(spec);
  for (const char* name : {"phase", "turned", "kidnap", "rig", "noise_seed", "start_s"}) {
    ASSERT_TRUE(ApplySimulationOption(name, kOthers.at(name), spec).ok());
  }
  EXPECT_EQ(WorldName(spec), world);
  for (const char* name : {"seed", "world", "length", "look_alike"}) {
    SimulationSpec other;
    ASSERT_TRUE(ApplySimulationOption(name, kOthers.at(name), other).ok());
    EXPECT_NE(WorldName(other), world) << name;
  }
}

TEST(SimulatedWorldTest, NamesAreReadFromText) {
  EXPECT_EQ(*ParseSimulatedWorld("floor"), SimulatedWorld::kFloor);
  EXPECT_THAT(std::string(ParseSimulatedWorld("moon").status().message()),
              HasSubstr("city, path, floor"));
}

}  // namespace
}  // namespace corbslam
