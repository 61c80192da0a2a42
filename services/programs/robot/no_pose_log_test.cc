#include "services/programs/robot/no_pose_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "client_agent/source/pictures/mask_picture.h"

namespace corbslam::services {
namespace {

using client_agent::MaskedPercent;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::WhyNoPose;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NoPoseLogTest : public ::testing::Test {
 protected:
  // Adds a frame every tenth of a second.
  void Add(TrackingState state, WhyNoPose why, int frames, const cv::Mat& grey = Grey(0)) {
    for (int i = 0; i < frames; ++i) {
      TrackingResult result;
      result.timestamp_ns = now_ns_ += 100'000'000;
      result.state = state;
      result.why_no_pose = why;
      result.local_map = map_;
      result.points_matched = 90;
      result.foreign_points_matched = foreign_;
      if (const auto line = log_.Add(result, {now_ns_, grey, grey})) lines_.push_back(*line);
    }
  }
  void Track(int frames) { Add(TrackingState::kTracking, WhyNoPose::kHasOne, frames); }

  static cv::Mat Grey(int level) { return cv::Mat(48, 64, CV_8UC1, cv::Scalar(level)); }
  // Half black, half white enough to have contrast.
  static cv::Mat Halves() {
    cv::Mat picture = Grey(20);
    picture.colRange(0, 32) = cv::Scalar(200);
    return picture;
  }

  NoPoseLog log_;
  LocalMapId map_{1};
  int foreign_ = 0;
  int64_t now_ns_ = 5'000'000'000;
  std::vector<std::string> lines_;
};

TEST_F(NoPoseLogTest, SaysNothingWhileAllIsWellOrAMomentIsMissing) {
  Track(20);
  Add(TrackingState::kLost, WhyNoPose::kNotRecognised, 9);
  Track(20);
  EXPECT_THAT(lines_, IsEmpty());
}

TEST_F(NoPoseLogTest, AStartInTheDarkIsExplainedUntilItIsOver) {
  Add(TrackingState::kNotInitialised, WhyNoPose::kFewKeypoints, 30, Grey(7));
  Track(1);
  EXPECT_THAT(lines_, ElementsAre(AllOf(HasSubstr("no map begun for 1.0 s"),
                                        HasSubstr("dark (99 % of it are below 8 of 255)")),
                                  HasSubstr("a map is begun after 3.0 s")));
}

TEST_F(NoPoseLogTest, TellsWhatThePictureLacks) {
  const auto line_of = [this](WhyNoPose why, const cv::Mat& grey) {
    lines_.clear();
    Track(1);
    lines_.clear();
    Add(TrackingState::kNotInitialised, why, 12, grey);
    return lines_.empty() ? std::string() : lines_.front();
  };
  EXPECT_THAT(line_of(WhyNoPose::kFewKeypoints, Grey(255)), HasSubstr("overexposed"));
  EXPECT_THAT(line_of(WhyNoPose::kFewKeypoints, Grey(120)), HasSubstr("almost no contrast (0"));
  EXPECT_THAT(line_of(WhyNoPose::kFewKeypoints, Halves()), HasSubstr("blurred"));
  EXPECT_THAT(line_of(WhyNoPose::kFewDepths, Halves()), HasSubstr("corbslam rig check"));
  EXPECT_THAT(line_of(WhyNoPose::kMappingPaused, Halves()), HasSubstr("mapping is paused"));
}

TEST_F(NoPoseLogTest, AMaskThatLeavesMostOutIsNamed) {
  StereoCalibration calibration;
  EXPECT_EQ(MaskedPercent(calibration), 0);
  calibration.mask = Grey(0);
  calibration.mask.colRange(0, 16) = cv::Scalar(255);
  log_ = NoPoseLog(MaskedPercent(calibration));
  Add(TrackingState::kNotInitialised, WhyNoPose::kFewKeypoints, 12, Halves());
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("the rig's mask leaves 75 % of it out")));
}

TEST_F(NoPoseLogTest, BeingLostIsToldEveryTenSecondsAndHowItEnded) {
  Track(5);
  Add(TrackingState::kLost, WhyNoPose::kNotRecognised, 215);
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("lost for 1.0 s"), HasSubstr("lost for 11.0 s"),
                                  HasSubstr("lost for 21.0 s")));
  Track(5);
  EXPECT_THAT(lines_.back(), HasSubstr("found again in its map after 21.5 s"));
  Add(TrackingState::kLost, WhyNoPose::kNotRecognised, 15);
  map_ = LocalMapId{2};
  Track(1);
  EXPECT_THAT(lines_.back(), HasSubstr("a map is begun after 1.5 s"));
}

// A robot that only localises begins no map.
TEST_F(NoPoseLogTest, WhereItIsInOthersMapsIsToldAsThat) {
  Add(TrackingState::kLost, WhyNoPose::kNotRecognised, 15);
  foreign_ = 90;
  Track(1);
  EXPECT_THAT(lines_.back(), HasSubstr("found in what others mapped after 1.5 s"));
}

}  // namespace
}  // namespace corbslam::services
