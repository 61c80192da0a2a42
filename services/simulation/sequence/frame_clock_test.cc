#include "services/simulation/sequence/frame_clock.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

TEST(FrameClockTest, HasAFrameAtBothEnds) {
  const FrameClock clock({}, 10, 2 * kSecond_ns);
  ASSERT_EQ(clock.frame_count(), 21u);
  EXPECT_EQ(clock.WayTimeAt(0), 0);
  EXPECT_EQ(clock.WayTimeAt(20), 2 * kSecond_ns);
  EXPECT_EQ(clock.TimestampAt(7), 700'000'000);
  EXPECT_EQ(clock.WayTimeAt(7, 5'000'000), 705'000'000);
}

TEST(FrameClockTest, CountsAtOddRates) {
  // There are 3 frames, a thirtieth of a second apart.
  EXPECT_EQ(FrameClock({}, 30, 66'666'667).frame_count(), 3u);
  EXPECT_EQ(FrameClock({}, 30, 66'000'000).frame_count(), 2u);
}

TEST(FrameClockTest, PhaseIsAShareOfAFrame) {
  SimulationSpec spec;
  spec.phase = 0.5;
  spec.start_s = 3600;
  const FrameClock clock(spec, 10, 2 * kSecond_ns);
  EXPECT_EQ(clock.frame_count(), 20u);
  EXPECT_EQ(clock.WayTimeAt(3), 350'000'000);
  EXPECT_EQ(clock.TimestampAt(3), 3600 * kSecond_ns + 350'000'000);
}

TEST(FrameClockTest, TurnedTakesTheSamePlacesFromTheOtherEnd) {
  for (const double phase : {0.0, 0.5, 0.3}) {
    SimulationSpec spec;
    spec.phase = phase;
    const FrameClock forwards(spec, 10, 2 * kSecond_ns + 30'000'000);
    spec.turned = true;
    const FrameClock turned(spec, 10, 2 * kSecond_ns + 30'000'000);
    ASSERT_EQ(turned.frame_count(), forwards.frame_count());
    for (size_t i = 0; i < forwards.frame_count(); ++i) {
      EXPECT_EQ(turned.WayTimeAt(i), forwards.WayTimeAt(forwards.frame_count() - 1 - i));
      EXPECT_EQ(turned.TimestampAt(i), forwards.TimestampAt(i));
    }
    EXPECT_LT(turned.WayTimeAt(3, 1000), turned.WayTimeAt(3));
  }
}

TEST(FrameClockTest, SetsOffSmoothlyAndHasItsSpeedThen) {
  SimulationSpec spec;
  spec.beginning.still_s = 1;
  spec.set_off_s = 2;
  const FrameClock clock(spec, 10, 4 * kSecond_ns);
  EXPECT_EQ(clock.WayTimeAt(10), 0);
  EXPECT_EQ(clock.WayTimeAt(20), 187'500'000);
  EXPECT_EQ(clock.WayTimeAt(30), kSecond_ns);
  EXPECT_EQ(clock.WayTimeAt(40), 2 * kSecond_ns);
  EXPECT_EQ(clock.frame_count(), 61u);
  EXPECT_EQ(clock.WayTimeAt(60), 4 * kSecond_ns);
  EXPECT_EQ(clock.PhysicalSpan().last_ns, 6 * kSecond_ns);
  spec.turned = true;
  const FrameClock turned(spec, 10, 4 * kSecond_ns);
  EXPECT_EQ(turned.WayTimeAt(10), 4 * kSecond_ns);
  EXPECT_EQ(turned.WayTimeAt(60), 0);
}

TEST(FrameClockTest, IsABodyBetweenTheEndsOfTheWay) {
  SimulationSpec spec;
  spec.phase = 0.5;
  const FrameClock forwards(spec, 10, 2 * kSecond_ns);
  EXPECT_EQ(forwards.PhysicalSpan().first_ns, 0);
  EXPECT_EQ(forwards.PhysicalSpan().last_ns, 2 * kSecond_ns);
  spec.turned = true;
  const FrameClock turned(spec, 10, 1'990'000'000);
  const TimeSpan span = turned.PhysicalSpan();
  EXPECT_EQ(turned.WayTimeOf(span.first_ns), 1'990'000'000);
  EXPECT_EQ(turned.WayTimeOf(span.last_ns), 0);
  EXPECT_LE(span.first_ns, turned.ElapsedAt(0));
}

TEST(FrameClockTest, KidnappedGoesOnFromAnotherPlace) {
  SimulationSpec spec;
  spec.kidnap = Kidnap{0.5, 1.5};
  const FrameClock ahead(spec, 10, 2 * kSecond_ns);
  EXPECT_EQ(ahead.WayTimeAt(4), 400'000'000);
  EXPECT_EQ(ahead.WayTimeAt(5), 1'500'000'000);
  EXPECT_EQ(ahead.TimestampAt(5), 500'000'000);
  EXPECT_EQ(ahead.frame_count(), 11u);
  spec.kidnap = Kidnap{1.5, 0.5};
  const FrameClock back(spec, 10, 2 * kSecond_ns);
  EXPECT_EQ(back.WayTimeAt(15), 500'000'000);
  EXPECT_EQ(back.frame_count(), 31u);
}

TEST(FrameClockTest, IsDarkDuringTheBlackoutOnly) {
  SimulationSpec spec;
  spec.blackout = {0.5, 0.3};
  const FrameClock clock(spec, 10, 2 * kSecond_ns);
  for (size_t i = 0; i < clock.frame_count(); ++i) {
    EXPECT_EQ(clock.IsDark(i), i >= 5 && i < 8) << i;
  }
  EXPECT_FALSE(FrameClock({}, 10, kSecond_ns).IsDark(0));
}

}  // namespace
}  // namespace corbslam
