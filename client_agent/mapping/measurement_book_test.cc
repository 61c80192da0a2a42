#include "client_agent/mapping/measurement_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr LocalMapId kOwn{7};

KeypointMeasurement MakeKeypointMeasurement(uint32_t keyframe, uint32_t keypoint, double shift_px,
                                            double variance_px2) {
  KeypointMeasurement measurement;
  measurement.keyframe = {kOwn, keyframe};
  measurement.keypoint = keypoint;
  measurement.shift_px = {shift_px, -shift_px};
  measurement.variance_px2 = variance_px2;
  return measurement;
}

Keypoint MakeKeypoint(float disparity_px, uint8_t octave = 0) {
  return {.x_px = 100, .y_px = 50, .disparity_px = disparity_px, .octave = octave};
}

TEST(MeasurementBookTest, AveragesByVariance) {
  MeasurementBook book;
  KeypointMeasurement measurement = MakeKeypointMeasurement(1, 1, 3, 1);
  measurement.disparity_shift_px = 1;
  measurement.disparity_variance_px2 = 0.5;
  book.Add({measurement, MakeKeypointMeasurement(1, 1, -1, 0.5)});
  const auto taken = book.TakeUpTo({kOwn, 1});
  ASSERT_THAT(taken, SizeIs(1));
  const auto moved =
      Averaged({MakeKeypoint(20), MakeKeypoint(20), MakeKeypoint(20)}, taken.begin()->second);
  EXPECT_EQ(moved[0], MakeKeypoint(20));
  EXPECT_EQ(moved[2], MakeKeypoint(20));
  // The keypoint's own variance is 1 px^2: it moves by (0 + 3 - 2) / (1 + 1 + 2), and its disparity
  // by (0 + 2) / (1 + 2).
  EXPECT_FLOAT_EQ(moved[1].x_px, 100.25F);
  EXPECT_FLOAT_EQ(moved[1].y_px, 49.75F);
  EXPECT_FLOAT_EQ(moved[1].disparity_px, 20 + 2 / 3.F);
}

TEST(MeasurementBookTest, ACoarseKeypointGivesWayToFineLooks) {
  const double variance_px2 = ScalePyramid::Variance_px2(4);
  MeasurementBook book;
  book.Add({MakeKeypointMeasurement(0, 0, 1, 1)});
  const auto moved = Averaged({MakeKeypoint(0, 4)}, book.TakeUpTo({kOwn, 0}).begin()->second);
  EXPECT_NEAR(moved[0].x_px, 100 + variance_px2 / (variance_px2 + 1), 1e-5);
}

TEST(MeasurementBookTest, DepthIsNeitherMadeNorLost) {
  MeasurementBook book;
  for (const double shift_px : {5.0, -5.0}) {
    KeypointMeasurement measurement = MakeKeypointMeasurement(0, shift_px > 0 ? 0 : 1, 0, 1);
    measurement.disparity_shift_px = shift_px;
    measurement.disparity_variance_px2 = 0.1;
    book.Add({measurement});
  }
  const auto moved =
      Averaged({MakeKeypoint(0), MakeKeypoint(1)}, book.TakeUpTo({kOwn, 0}).begin()->second);
  EXPECT_EQ(moved[0].disparity_px, 0) << "it had none";
  EXPECT_EQ(moved[1].disparity_px, 1) << "it would have none";
}

TEST(MeasurementBookTest, LooksAreTakenOnce) {
  MeasurementBook book;
  book.Add({MakeKeypointMeasurement(1, 0, 1, 1), MakeKeypointMeasurement(2, 0, 1, 1),
            MakeKeypointMeasurement(3, 0, 1, 1)});
  EXPECT_THAT(book.TakeUpTo({kOwn, 2}), SizeIs(2));
  EXPECT_THAT(book.TakeUpTo({kOwn, 2}), IsEmpty());
  const auto taken = book.TakeUpTo({kOwn, 9});
  ASSERT_THAT(taken, SizeIs(1));
  EXPECT_EQ(taken.begin()->first, (KeyframeId{kOwn, 3}));
}

TEST(MeasurementBookTest, LooksThatComeTooLateAreNone) {
  MeasurementBook book;
  EXPECT_THAT(book.TakeUpTo({kOwn, 3}), IsEmpty());
  book.Add({MakeKeypointMeasurement(3, 0, 1, 1)});
  EXPECT_THAT(book.TakeUpTo({kOwn, 2}), IsEmpty());
  book.Add({MakeKeypointMeasurement(3, 0, 1, 1), MakeKeypointMeasurement(4, 0, 1, 1)});
  const auto taken = book.TakeUpTo({kOwn, 9});
  ASSERT_THAT(taken, SizeIs(1));
  EXPECT_EQ(taken.begin()->first, (KeyframeId{kOwn, 4}));
}

TEST(MeasurementBookTest, LooksBeyondTheKeypointsAreNone) {
  EXPECT_THAT(Averaged({}, KeyframeMeasurements(3, MeasurementSum{.weight = 1})), IsEmpty());
}

}  // namespace
}  // namespace corbslam::client_agent
