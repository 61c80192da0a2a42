#include "client_agent/source/bag/bag_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "client_agent/source/bag/bag_source.h"
#include "client_agent/source/bag/bag_summary.h"
#include "client_agent/source/bag/testing/drawn_bags.h"
#include "client_agent/source/recorded_sequence.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Opens "NAME?OPTIONS" as programs do.
absl::StatusOr<std::unique_ptr<FrameReader>> Open(const std::string& bag) {
  RegisterBagSource();
  const auto spec = ParseSourceSpec("bag:" + bag);
  if (!spec.ok()) return spec.status();
  return OpenReader(*spec);
}

std::string Refusal(const std::string& bag) {
  return std::string(Open(DrawnBag(bag)).status().message());
}

TEST(BagReaderTest, EachBagHoldsTheDrawnPair) {
  for (const char* name : kStereoBags) {
    const auto reader = Open(DrawnBag(name));
    ASSERT_TRUE(reader.ok()) << name << ": " << reader.status();
    ASSERT_EQ((*reader)->frame_count(), 3u) << name;
    EXPECT_THAT((*reader)->description().remarks.findings, IsEmpty()) << name;
    for (int i = 0; i < 3; ++i) {
      const auto frame = static_cast<size_t>(i);
      EXPECT_EQ((*reader)->timestamp_ns(frame), kDrawnStart_ns + i * 100'000'000) << name;
      const auto images = (*reader)->Read(frame);
      ASSERT_TRUE(images.ok()) << name << ": " << images.status();
      EXPECT_EQ(cv::norm(images->grey, DrawnPicture(i, 0), cv::NORM_INF), 0) << name;
      EXPECT_EQ(cv::norm(images->right, DrawnPicture(i, 1), cv::NORM_INF), 0) << name;
    }
    const auto& stereo = std::get<StereoCalibration>((*reader)->calibration());
    EXPECT_FALSE(stereo.raw.has_value());
    EXPECT_EQ(stereo.camera.fx_px, 40) << name;
    EXPECT_EQ(stereo.camera.cy_px, 14.5) << name;
    EXPECT_DOUBLE_EQ(stereo.camera.baseline_m, 0.1) << name;
  }
}

TEST(BagReaderTest, DepthIsRegisteredByTheFixedFrames) {
  for (const char* name : {"depth.bag", "depth.mcap"}) {
    const auto reader = Open(DrawnBag(name));
    ASSERT_TRUE(reader.ok()) << name << ": " << reader.status();
    ASSERT_EQ((*reader)->frame_count(), 3u);
    const auto images = (*reader)->Read(1);
    ASSERT_TRUE(images.ok()) << images.status();
    EXPECT_EQ(cv::norm(images->grey, DrawnPicture(1, 0), cv::NORM_INF), 0);
    ASSERT_EQ(images->depth.type(), CV_16UC1);
    EXPECT_EQ(images->depth.at<uint16_t>(15, 20), 1100);
    // The camera of depth sits 30 mm to the side: a pixel at 1.1 m.
    EXPECT_THAT((*reader)->description().depth_registration, HasSubstr("30.0 mm"));
    EXPECT_EQ(std::get<RgbdCalibration>((*reader)->calibration()).depth_units_per_m, 1000);
  }
}

TEST(BagReaderTest, TopicsAreNamed) {
  const std::string left = "/stereo/left/image_raw";
  const std::string right = "/stereo/right/image_raw";
  EXPECT_TRUE(Open(DrawnBag("stereo_zstd.mcap?left=" + left + "&right=" + right)).ok());
  EXPECT_TRUE(Open(DrawnBag("stereo_png.mcap?left=" + left)).ok())
      << "the transport's end is known";
  EXPECT_THAT(Refusal("stereo_zstd.mcap?left=" + right + "&right=" + left),
              HasSubstr("to the left of"));
  EXPECT_THAT(Refusal("stereo_zstd.mcap?left=/front"),
              AllOf(HasSubstr("?left=/front: no topic of pictures"), HasSubstr(left)));
  EXPECT_THAT(Refusal("stereo_zstd.mcap?depth=" + right), HasSubstr("no RGB-D camera"));
  EXPECT_THAT(Refusal("stereo_zstd.mcap?right=a&depth=b"), HasSubstr("right and depth"));
  EXPECT_THAT(Refusal("stereo_zstd.mcap?left_info=/none"), HasSubstr("CameraInfo on topic /none"));
  EXPECT_THAT(Refusal("stereo_zstd.mcap?middle=/a"), HasSubstr("middle"));
}

TEST(BagReaderTest, OptionsAreWrittenAsTheyAreRead) {
  RegisterBagSource();
  const std::string text =
      "bag:/a.mcap?left=/l&depth=/d&left_info=/i&rig=r.yaml&time=recording&scale=0.5&"
      "trust_calibration=1&pair_within_ms=5&depth_units=5000&register=0&frames=1:2";
  const auto spec = ParseSourceSpec(text);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(FormatSourceSpec(*spec), text);
  EXPECT_EQ(FindBag(*spec)->pair_within_ms, 5);
  EXPECT_FALSE(ParseSourceSpec("bag:/a.mcap?time=now").ok());
  EXPECT_FALSE(ParseSourceSpec("bag:/a.mcap?scale=2").ok());
}

TEST(BagReaderTest, ARigFileIsTakenInsteadOfCameraInfo) {
  const std::string rig = WriteBytes("bag_rig.yaml", R"(rig: 1
kind: stereo
rectified: true
baseline_m: 0.25
cameras:
  - {size_px: [40, 30], focal_px: [41, 41], principal_px: [20, 15]}
  - {size_px: [40, 30], focal_px: [41, 41], principal_px: [20, 15]}
)");
  const auto reader = Open(DrawnBag("stereo_lz4.bag?rig=" + rig));
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto& stereo = std::get<StereoCalibration>((*reader)->calibration());
  EXPECT_EQ(stereo.camera.fx_px, 41);
  EXPECT_EQ(stereo.camera.baseline_m, 0.25);
  EXPECT_THAT(Refusal("depth.mcap?rig=" + rig), HasSubstr("no stereo pair"));
}

TEST(BagReaderTest, OneCameraOfAPairIsPlayedAlone) {
  RegisterBagSource();
  const auto sequence = OpenSource("bag:" + DrawnBag("stereo_bz2.bag") + "?cameras=1");
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  EXPECT_EQ(KindOf((*sequence)->calibration()), SensorKind::kMonocular);
  const auto first = (*sequence)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_TRUE((*first)->right.empty());
  const std::string rig = WriteBytes("one_rig.yaml", R"(rig: 1
kind: monocular
cameras:
  - {size_px: [40, 30], focal_px: [41, 41], principal_px: [20, 15]}
)");
  EXPECT_THAT(Refusal("stereo_lz4.bag?rig=" + rig), HasSubstr("is of one camera alone"));
}

TEST(BagReaderTest, TheRecordersTimeIsTakenWhereAsked) {
  const auto reader = Open(DrawnBag("stereo_split?time=recording"));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->timestamp_ns(0), kDrawnStart_ns + 3'000'000);
}

TEST(BagReaderTest, FramesAreSelectedAsOfAnySource) {
  RegisterBagSource();
  const auto sequence = OpenSource("bag:" + DrawnBag("stereo_bz2.bag") + "?reverse=1&frames=1:2");
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  const auto first = (*sequence)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ(cv::norm((*first)->grey, DrawnPicture(2, 0), cv::NORM_INF), 0);
}

TEST(BagReaderTest, TheSummarySaysWhatIsThereAndWhatIsPlayed) {
  BagOptions options;
  options.path = DrawnBag("depth.mcap");
  const auto summary = SummariseBag(options);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->messages, 13u);
  EXPECT_EQ(summary->lacking, "");
  const std::string text = FormatBagSummary(*summary);
  EXPECT_THAT(text, HasSubstr("/tf_static"));
  EXPECT_THAT(text, HasSubstr("depth, 16UC1; compressedDepth png 40x30, frame 'depth'"));
  EXPECT_THAT(text, HasSubstr("played as it is:"));
  options.left = "/nowhere";
  EXPECT_THAT(FormatBagSummary(*SummariseBag(options)), HasSubstr("nothing can be played: "));
}

TEST(BagReaderTest, DamageIsAFinding) {
  const std::string whole = ReadBytes(DrawnBag("stereo_unchunked.mcap"));
  const auto reader = Open(WriteBytes("half.mcap", whole.substr(0, 9000)));
  ASSERT_TRUE(reader.ok()) << reader.status();
  ASSERT_FALSE((*reader)->description().remarks.findings.empty());
  bool is_told = false;
  for (const SourceFinding& finding : (*reader)->description().remarks.findings) {
    is_told = is_told || finding.code == "bag-not-whole";
  }
  EXPECT_TRUE(is_told);
}

// Returns all bags of other projects: files, and folders with metadata.
std::vector<std::string> OthersBags(const std::string& folder) {
  std::vector<std::string> bags;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    const bool is_folder = fs::exists(entry.path() / "metadata.yaml");
    if (is_folder || ending == ".bag" || ending == ".mcap" || ending == ".db3") {
      bags.push_back(entry.path().string());
    }
  }
  return bags;
}

TEST(BagReaderTest, BagsOfOtherProjectsAreReadOrRefusedByName) {
  const char* const data = std::getenv("CORBSLAM_DATA_DIR");
  if (data == nullptr || !fs::exists(std::string(data) + "/bags")) {
    GTEST_SKIP() << "CORBSLAM_DATA_DIR has no bags";
  }
  size_t read = 0;
  for (const std::string& bag : OthersBags(std::string(data) + "/bags")) {
    BagOptions options;
    options.path = bag;
    const auto summary = SummariseBag(options);
    if (!summary.ok()) {
      EXPECT_THAT(std::string(summary.status().message()), HasSubstr(bag));
      continue;
    }
    ++read;
    EXPECT_THAT(summary->notes, IsEmpty()) << bag;
    EXPECT_THAT(summary->lacking, HasSubstr("no pictures")) << bag;
  }
  EXPECT_GE(read, 25u);
}

}  // namespace
}  // namespace corbslam::client_agent
