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
  files.truths = {Write("truth.txt", std::string(kRows) + "4 nan 0 0 0 0 0 1\n")};
  files.estimates = {Write("a.txt", kRows), Write("b.txt", std::string(kRows) + kRows)};
  files.from_frame = 1;
  const auto input = ReadEvaluationInput(files);
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_THAT(input->truths, SizeIs(1));
  EXPECT_THAT(input->TruthOf(1), SizeIs(3));
  EXPECT_TRUE(input->is_one_frame);
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
  files.truths = {Write("truth.txt", kRows)};
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
  files.truths = {Write("truth_of_camera.txt", Of(PosesOf::kRecordedCamera))};
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("the estimates of the body"));
}

TEST(EvaluationInputTest, TheTruthMustHoldAPose) {
  EvaluationFiles files;
  files.estimates = {Write("a.txt", kRows)};
  files.truths = {Write("truth.txt", "# none\n")};
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("holds no pose"));
  files.truths = {TestPath("nowhere.txt")};
  EXPECT_TRUE(absl::IsNotFound(ReadEvaluationInput(files).status()));
  files.truths = {"kitti:/nowhere"};
  EXPECT_TRUE(absl::IsNotFound(ReadEvaluationInput(files).status()));
  files.truths = {"nosuch:layout"};
  EXPECT_TRUE(absl::IsInvalidArgument(ReadEvaluationInput(files).status()));
}

constexpr char kLaterRows[] = "11 1 0 0 0 0 0 1\n12 2 0 0 0 0 0 1\n13 3 0 0 0 0 0 1\n";

// Their clocks may be one: the second robot drove at the times of the first one.
TEST(EvaluationInputTest, EachEstimateMayHaveATruthOfItsOwn) {
  EvaluationFiles files;
  files.truths = {Write("first.txt", kRows), Write("second.txt",
                                                   "1 5 0 0 0 0 0 1\n"
                                                   "2 6 0 0 0 0 0 1\n")};
  files.estimates = {Write("a.txt", kRows), Write("b.txt", kRows)};
  files.from_frame = 1;
  const auto own = ReadEvaluationInput(files);
  ASSERT_TRUE(own.ok()) << own.status();
  EXPECT_THAT(own->TruthOf(0), SizeIs(3));
  EXPECT_THAT(own->TruthOf(1), SizeIs(2));
  EXPECT_THAT(own->estimates[1], SizeIs(2));
  EXPECT_FALSE(own->is_one_frame);
  files.is_truth_shared = true;
  EXPECT_TRUE(ReadEvaluationInput(files)->is_one_frame);
  files.truth_times = "times.txt";
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("--truth-times is of one --truth"));
}

// A robot's trajectory goes through both of its drives.
TEST(EvaluationInputTest, TruthsOfOneFrameThatFollowEachOtherMayServeForAll) {
  EvaluationFiles files;
  files.truths = {Write("later.txt", kLaterRows), Write("first.txt", kRows)};
  files.estimates = {Write("a.txt", std::string(kRows) + kLaterRows)};
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("--truth is given 2 times for 1 trajectories"));
  files.is_truth_shared = true;
  const auto input = ReadEvaluationInput(files);
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_THAT(input->truths, SizeIs(1));
  ASSERT_THAT(input->TruthOf(0), SizeIs(6));
  EXPECT_EQ(input->TruthOf(0).back().timestamp_ns, 13'000'000'000);
  files.from_frame = 1;
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("which sequence's frame"));
  files.from_frame.reset();
  files.truths[0] = Write("same_time.txt", "3 1 0 0 0 0 0 1\n");
  EXPECT_THAT(std::string(ReadEvaluationInput(files).status().message()),
              HasSubstr("are of one time"));
}

}  // namespace
}  // namespace corbslam::services
