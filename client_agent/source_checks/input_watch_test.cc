#include "client_agent/source_checks/input_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// `with_depth` of `count` features have a disparity of `disparity_px`.
Features MakeFeatures(size_t count, size_t with_depth, float disparity_px = 12) {
  Features features;
  features.keypoints.resize(count);
  features.descriptors.resize(count);
  for (size_t i = 0; i < with_depth; ++i) features.keypoints[i].disparity_px = disparity_px;
  return features;
}

// Returns what is told in `frames` frames.
std::vector<std::string> Feed(InputWatch& watch, const Features& features, int frames) {
  std::vector<std::string> texts;
  for (int i = 0; i < frames; ++i) {
    const std::optional<SourceFinding> finding = watch.Add(features);
    if (finding.has_value()) texts.push_back(finding->code + ": " + finding->text);
  }
  return texts;
}

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(InputWatchTest, TellsAPairThatIsNoneOnceAfterItsFirstFrames) {
  InputWatch watch{SensorCalibration(StereoCalibration())};
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 150), 49), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 150), 1),
              ElementsAre(AllOf(HasSubstr("stereo-points-few: stereo points are 7.5 %"),
                                HasSubstr("less than 12 % is no basis"))));
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 90), 300), IsEmpty());
}

TEST(InputWatchTest, TellsThatDepthFailsLaterAndThatItFailsAgain) {
  InputWatch watch{SensorCalibration(RgbdCalibration())};
  EXPECT_THAT(Feed(watch, MakeFeatures(1000, 700), 100), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(1000, 0), 60),
              ElementsAre(AllOf(HasSubstr("depth-points-few: depth was found for"),
                                HasSubstr("less than 2 % is no basis"))));
  EXPECT_THAT(Feed(watch, MakeFeatures(1000, 700), 60), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(1000, 0), 60),
              ElementsAre(HasSubstr("depth-points-few: depth was found for")));
}

TEST(InputWatchTest, TellsAPairWithoutParallax) {
  InputWatch watch{SensorCalibration(StereoCalibration())};
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 1900, 0.01F), 50),
              ElementsAre(HasSubstr("stereo-points-without-parallax: 100 %")));
}

TEST(InputWatchTest, LetsAMomentInTheDarkAndABareWallPass) {
  InputWatch watch{SensorCalibration(StereoCalibration())};
  EXPECT_THAT(Feed(watch, MakeFeatures(20, 0), 100), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 1000), 50), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(99, 0), 200), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 0), 20), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(2000, 1000), 50), IsEmpty());
  EXPECT_THAT(Feed(watch, MakeFeatures(400, 28), 200), IsEmpty());
}

TEST(InputWatchTest, LetsAFarHorizonPass) {
  InputWatch watch{SensorCalibration(StereoCalibration())};
  Features features = MakeFeatures(2000, 1200, 0.2F);
  for (size_t i = 0; i < 120; ++i) features.keypoints[i].disparity_px = 6;
  EXPECT_THAT(Feed(watch, features, 200), IsEmpty());
}

TEST(InputWatchTest, TellsThatRowsArePutRightAndWhereThatChangedSince) {
  InputWatch watch{SensorCalibration(StereoCalibration())};
  EXPECT_FALSE(watch.AddRows(0).has_value());
  const std::optional<SourceFinding> found = watch.AddRows(0.31);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->code, "pair-rows-put-right");
  EXPECT_THAT(found->text, HasSubstr("0.31 px lower"));
  EXPECT_FALSE(watch.AddRows(0.36).has_value());
  EXPECT_THAT(watch.AddRows(-0.2)->text, HasSubstr("0.20 px higher"));
}

}  // namespace
}  // namespace corbslam::client_agent
