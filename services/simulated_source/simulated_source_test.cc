#include "services/simulated_source/simulated_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/recorded_sequence.h"
#include "client_agent/source/source_kinds.h"

namespace corbslam::services {

using client_agent::ApplyOptions;
using client_agent::FormatSourceSpec;
using client_agent::FramesOf;
using client_agent::KnownSourceKinds;
using client_agent::OpenReader;
using client_agent::OpenSource;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using client_agent::SourceUsage;

namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

TEST(SimulatedSourceTest, IsOneOfTheKindsOnceItIsRegistered) {
  RegisterSimulatedSources();
  EXPECT_THAT(KnownSourceKinds(), ElementsAre("kitti", "euroc", "tum", "7scenes", "sim"));
  EXPECT_THAT(SourceUsage(), EndsWith("7scenes:DIR or sim:WORLD"));
}

TEST(SimulatedSourceTest, ComesBackAsFormatted) {
  for (const char* text :
       {"sim:city", "sim:floor?rig=rgbd&motion=fly",
        "sim:city?seed=7&world=3&length=812.5&turned=1&noise_seed=5&frames=3:9&robot=2/3&noise=2",
        "sim:path?poses=/a/00.txt&blackout=10:2&kidnap=5:20.25&threads=2",
        "sim:floor?motion=fly&beginning=1:0:1&set_off_s=2&imu=phone&imu_rate=100"}) {
    EXPECT_EQ(FormatSourceSpec(*ParseSourceSpec(text)), text);
  }
}

constexpr char kFisheyes[] =
    "rig: 1\nkind: stereo\nrate_hz: 12\ncameras:\n"
    "  - {size_px: [160, 120], focal_px: [60, 60], principal_px: [80, 60], lens: equidistant, "
    "lens_numbers: [0, 0, 0, 0]}\n"
    "  - {size_px: [160, 120], focal_px: [61, 61], principal_px: [79, 60], lens: equidistant, "
    "lens_numbers: [0, 0, 0, 0]}\n"
    "right_from_left: [1, 0, 0, -0.2, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";

TEST(SimulatedSourceTest, TakesItsCamerasFromARigFile) {
  const std::string path = ::testing::TempDir() + "/simulated_fisheyes.yaml";
  std::ofstream(path) << kFisheyes;
  const auto spec = ParseSourceSpec("sim:city?length=120&rig=" + path);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(FormatSourceSpec(*spec), "sim:city?length=120&rig=" + path);
  const auto reader = OpenReader(*spec);
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto& stereo = std::get<StereoCalibration>((*reader)->calibration());
  ASSERT_TRUE(stereo.raw.has_value());
  EXPECT_EQ(stereo.raw->right.fx_px, 61);
  EXPECT_EQ((*reader)->timestamp_ns(12), 1'000'000'000);
  const auto images = (*reader)->Read(3);
  ASSERT_TRUE(images.ok()) << images.status();
  EXPECT_EQ(images->grey.size(), cv::Size(160, 120));
  EXPECT_GT(cv::mean(images->right)[0], 20);
  SourceSpec by_flag = *ParseSourceSpec("sim:city?length=120");
  ASSERT_TRUE(client_agent::UseRig(path, by_flag).ok());
  EXPECT_EQ(FormatSourceSpec(by_flag), FormatSourceSpec(*spec));
}

TEST(SimulatedSourceTest, NamesWhatItDoesNotUnderstand) {
  const std::pair<const char*, const char*> cases[] = {
      {"sim:moon", "city, path, floor"},
      {"sim:city?sead=7", "'sead': known are"},
      {"sim:city?sead=7", "blackout"},
      {"sim:city?seed=x", "seed=x"},
      {"sim:city?rig=gopro", "rig=gopro"},
      {"sim:city?rig=/no.yaml", "/no.yaml"},
      {"sim:city?hand=3", "hand=3"},
      {"sim:city?exposure_steps=5:0.3/2:1", "exposure_steps=2"},
      {"sim:city?phase=2", "phase=2"},
      {"sim:path", "poses"},
      {"sim:city?imu=/no.csv", "/no.csv"},
      {"sim:city?imu=best", "imu=best"}};
  for (const auto& [text, expected] : cases) {
    const absl::Status status = ParseSourceSpec(text).status();
    const bool lacks_file = std::string(expected).starts_with("/no.");
    EXPECT_EQ(status.code(),
              lacks_file ? absl::StatusCode::kNotFound : absl::StatusCode::kInvalidArgument)
        << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr(expected));
  }
}

TEST(SimulatedSourceTest, CopiesOfASpecAreSetApart) {
  const SourceSpec city = *ParseSourceSpec("sim:city?seed=7");
  SourceSpec other = city;
  ASSERT_TRUE(ApplyOptions("seed=8", other).ok());
  EXPECT_EQ(FindSimulation(city)->seed, 7u);
  EXPECT_EQ(FindSimulation(other)->seed, 8u);
  EXPECT_EQ(FindSimulation(*ParseSourceSpec("kitti:a")), nullptr);
}

TEST(SimulatedSourceTest, HasASeedOfItsPictures) {
  const SourceSpec spec = *ParseSourceSpec("sim:city?seed=7&noise_seed=5&gamma=0.9");
  EXPECT_EQ(FindSimulation(spec)->seed, 7u);
  EXPECT_EQ(FindSimulation(spec)->lens.noise_seed, 5u);
  EXPECT_EQ(spec.perturbation.seed, 5u);
  EXPECT_EQ(spec.perturbation.gamma, 0.9);
}

TEST(SimulatedSourceTest, TurnedMeansTheSamePlaces) {
  const auto frames = [](const char* text) { return FramesOf(*ParseSourceSpec(text), 10); };
  EXPECT_THAT(frames("sim:city?frames=1:3"), ElementsAre(1, 2, 3));
  EXPECT_THAT(frames("sim:city?frames=1:3&turned"), ElementsAre(6, 7, 8));
  EXPECT_THAT(frames("sim:city?frames=1:3&turned&reverse"), ElementsAre(8, 7, 6));
  EXPECT_THAT(frames("sim:city?robot=2/2&overlap=1"), ElementsAre(4, 5, 6, 7, 8, 9));
  EXPECT_THAT(frames("sim:city?robot=2/2&overlap=1&turned"), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(SimulatedSourceTest, PlaysAPartAndDisturbsItsPictures) {
  const char* plain_spec = "sim:city?seed=3&length=120&picture_scale=0.1&robot=2/2&overlap=3";
  auto plain = OpenSource(plain_spec);
  ASSERT_TRUE(plain.ok()) << plain.status();
  auto noisy = OpenSource(absl::StrCat(plain_spec, "&gamma=0.5&threads=2"));
  ASSERT_TRUE(noisy.ok()) << noisy.status();
  const size_t frames = (*OpenSource("sim:city?seed=3&length=120"))->size();
  EXPECT_EQ((*plain)->size(), frames - frames / 2 + 3);
  EXPECT_EQ((*plain)->frame(0).number, frames / 2 - 3);
  const SensorImages first = **(*plain)->NextImages();
  EXPECT_EQ(first.timestamp_ns, (*plain)->frame(0).timestamp_ns);
  EXPECT_EQ(first.grey.size(), first.right.size());
  const SensorImages brighter = **(*noisy)->NextImages();
  EXPECT_GT(cv::mean(brighter.grey)[0], cv::mean(first.grey)[0] + 10);
}

// Returns the samples of all frames as they are played, one vector a frame.
std::vector<ImuSamples> PlayImu(const std::string& options) {
  auto sequence = OpenSource("sim:city?seed=3&length=120&picture_scale=0.1" + options);
  EXPECT_TRUE(sequence.ok()) << sequence.status();
  std::vector<ImuSamples> played;
  for (size_t i = 0; i < (*sequence)->size(); ++i) {
    played.push_back((**(*sequence)->NextImages()).imu);
  }
  return played;
}

TEST(SimulatedSourceTest, EachFrameComesWithWhatItsImuMeasuredSinceTheOneBefore) {
  const std::vector<ImuSamples> all = PlayImu("&imu=good&frames=30:34");
  // The samples go back for as long as a robot keeps any.
  EXPECT_EQ(all[0].front().timestamp_ns, 0);
  EXPECT_EQ(all[0].back().timestamp_ns, 3'000'000'000);
  for (size_t i = 1; i < all.size(); ++i) {
    ASSERT_EQ(all[i].size(), 20u);
    EXPECT_EQ(all[i].front().timestamp_ns, all[i - 1].back().timestamp_ns + 5'000'000);
  }
  const std::vector<ImuSamples> every_second = PlayImu("&imu=good&frames=30:34&stride=2");
  ASSERT_EQ(every_second.size(), 3u);
  EXPECT_EQ(every_second[1].size(), 40u);
  EXPECT_EQ(every_second[1][7].specific_force_mps2, all[1][7].specific_force_mps2);
}

TEST(SimulatedSourceTest, LateStampsComeWithLaterFrames) {
  const std::vector<ImuSamples> told = PlayImu("&imu=ideal&frames=30:32");
  const std::vector<ImuSamples> late = PlayImu("&imu=ideal&frames=30:32&imu_late_s=0.05");
  ASSERT_EQ(late[1].size(), 20u);
  EXPECT_EQ(late[1][15].timestamp_ns, told[1][15].timestamp_ns);
  EXPECT_EQ(late[1][15].specific_force_mps2, told[1][5].specific_force_mps2);
}

TEST(SimulatedSourceTest, HasNoImuUnlessAskedForNorBackwards) {
  for (const char* options :
       {"&frames=0:2", "&imu=good&frames=0:2&reverse=1", "&imu=0&frames=0:2"}) {
    for (const ImuSamples& samples : PlayImu(options)) EXPECT_TRUE(samples.empty()) << options;
  }
}

TEST(SimulatedSourceTest, NamesAFileThatIsNotThere) {
  EXPECT_EQ(OpenSource("sim:path?poses=/nowhere/00.txt").status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace corbslam::services
