#include "services/simulation/sequence/picture_events.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

TEST(PictureEventsTest, NothingHappensUnlessItIsAskedFor) {
  for (const double elapsed_s : {0.0, 0.5, 17.0}) {
    const PictureEvents events = EventsAt({}, elapsed_s);
    EXPECT_EQ(events.exposure, 1);
    EXPECT_EQ(events.defocus_px, 0);
    EXPECT_EQ(events.covered, 0);
  }
}

TEST(PictureEventsTest, ExposureJumpsFromStepToStep) {
  SimulationSpec spec;
  spec.exposure_steps = {{2, 0.25}, {3, 4}, {5, 1}};
  EXPECT_EQ(EventsAt(spec, 1.99).exposure, 1);
  EXPECT_DOUBLE_EQ(EventsAt(spec, 2).exposure, 0.25);
  EXPECT_DOUBLE_EQ(EventsAt(spec, 3.5).exposure, 4);
  EXPECT_DOUBLE_EQ(EventsAt(spec, 9).exposure, 1);
}

TEST(PictureEventsTest, IsBlurredBehindTheDarkAndThenSharp) {
  SimulationSpec spec;
  spec.beginning = {1, 2, 3};
  EXPECT_EQ(EventsAt(spec, 0.9).defocus_px, 0);
  EXPECT_GT(EventsAt(spec, 1).defocus_px, 3);
  EXPECT_GT(EventsAt(spec, 2.9).defocus_px, 3);
  EXPECT_EQ(EventsAt(spec, 3).defocus_px, 0);
}

TEST(PictureEventsTest, AHandComesAndGoes) {
  SimulationSpec spec;
  spec.hand = {4, 2};
  EXPECT_EQ(EventsAt(spec, 3.9).covered, 0);
  EXPECT_GT(EventsAt(spec, 4).covered, 0);
  EXPECT_LT(EventsAt(spec, 4.1).covered, 0.6);
  EXPECT_EQ(EventsAt(spec, 5).covered, 1);
  EXPECT_LT(EventsAt(spec, 5.9).covered, 0.5);
  EXPECT_EQ(EventsAt(spec, 6).covered, 0);
}

}  // namespace
}  // namespace corbslam
