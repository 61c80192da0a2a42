#include "client_agent/source_checks/sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(SampleTest, TakesRowsOfFramesFromTheFirstToTheLast) {
  EXPECT_THAT(ChooseSampleFrames(StereoCalibration(), 0, 101, {.places = 3, .stereo_row = 3}),
              ElementsAre(0, 1, 2, 49, 50, 51, 98, 99, 100));
  EXPECT_THAT(ChooseSampleFrames(RgbdCalibration(), 10, 100, {.places = 2, .rgbd_row = 4}),
              ElementsAre(10, 11, 12, 13, 96, 97, 98, 99));
  EXPECT_THAT(ChooseSampleFrames(StereoCalibration(), 5, 50, {.places = 1, .stereo_row = 2}),
              ElementsAre(5, 6));
}

TEST(SampleTest, TakesEachFrameOnceWhereThereAreFew) {
  EXPECT_THAT(ChooseSampleFrames(StereoCalibration(), 3, 7), ElementsAre(3, 4, 5, 6));
  EXPECT_THAT(ChooseSampleFrames(StereoCalibration(), 3, 4), ElementsAre(3));
  EXPECT_THAT(ChooseSampleFrames(RgbdCalibration(), 3, 3), IsEmpty());
  EXPECT_THAT(ChooseSampleFrames(RgbdCalibration(), 4, 3), IsEmpty());
}

}  // namespace
}  // namespace corbslam::client_agent
