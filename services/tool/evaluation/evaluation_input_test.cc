#include "services/tool/evaluation/evaluation_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "services/testing/test_path.h"
#include "slam/evaluation/pose_header.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

std::string Write(const std::string& name, const std::string& text) {
  const std::string path = TestPath(name);
  std::ofstream(path) << text;
  return path;
}

constexpr char kRows[] = "1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n3 3 0 0 0 0 0 1\n";

std::string Of(PosesOf poses_of) { return "# " + PoseHeaderLine(poses_of) + "\n" + kRows; }

TEST(EvaluationInputTest, ReadsFilesAndNotesWhatTheyLack) {
  EvaluationFiles files;
  files.truth = Write("truth.txt", std::string(kRows) + "4 nan 0 0 0 0 0 1\n");
  files.estimates = {Write("a.txt", kRows), Write("b.txt", std::string(kRows) + kRows)};
  files.from_frame = 1;
  const auto input = ReadEvaluationInput(files);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_THAT(input->truth, SizeIs(3));
  ASSERT_THAT(input->estimates, SizeIs(2));
  EXPECT_THAT(input->estimates[0], SizeIs(2));
  // In b.txt rows repeat times and one of them goes back; the truth has a row that isn't finite.
  EXPECT_THAT(input->notes, SizeIs(3));
  files.from_frame = 9;
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("the truth has 3"));
}

TEST(EvaluationInputTest, EstimatesMustBeOfOneFrame) {
  EvaluationFiles files;
  files.truth = Write("truth.txt", kRows);
  files.estimates = {Write("camera.txt", Of(PosesOf::kRecordedCamera)), Write("none.txt", kRows)};
  EXPECT_TRUE(ReadEvaluationInput(files).ok());
  files.estimates.push_back(Write("body.txt", Of(PosesOf::kBody)));
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("has poses of the body"));
  files.estimates = {files.estimates.back()};
  EXPECT_TRUE(ReadEvaluationInput(files).ok());
  files.poses_of = "camera";
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("--poses-of says the camera as recorded"));
  files.poses_of = "body";
  EXPECT_TRUE(ReadEvaluationInput(files).ok());
  files.truth = Write("truth_of_camera.txt", Of(PosesOf::kRecordedCamera));
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("the estimates of the body"));
}

TEST(EvaluationInputTest, TheTruthMustHoldAPose) {
  EvaluationFiles files;
  files.estimates = {Write("a.txt", kRows)};
  files.truth = Write("truth.txt", "# none\n");
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("holds no pose"));
  files.truth = TestPath("nowhere.txt");
  EXPECT_TRUE(absl::IsNotFound(ReadEvaluationInput(files).status()));
  files.truth = "kitti:/nowhere";
  EXPECT_TRUE(absl::IsNotFound(ReadEvaluationInput(files).status()));
  files.truth = "nosuch:layout";
  EXPECT_TRUE(absl::IsInvalidArgument(ReadEvaluationInput(files).status()));
}

}  // namespace
}  // namespace corbslam::services
