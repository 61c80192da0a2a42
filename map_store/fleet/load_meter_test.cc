#include "map_store/fleet/load_meter.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

LoadMeter::Reading At(double seconds, double processor_s) {
  LoadMeter::Reading reading;
  reading.time = absl::UnixEpoch() + absl::Seconds(seconds);
  reading.processor_s = processor_s;
  reading.processors = 4;
  reading.resident_bytes = 30;
  reading.budget_bytes = 100;
  return reading;
}

TEST(LoadMeterTest, TheFirstReadingSaysNothingAndASteadyLoadIsFoundWithinAMinute) {
  LoadMeter meter;
  EXPECT_FALSE(meter.Note(At(0, 100)).has_value());
  std::optional<WeighedStore> weighed;
  for (int i = 1; i <= 12; ++i) {
    LoadMeter::Reading reading = At(5 * i, 100 + 10 * i);
    reading.missions["a"] = {static_cast<uint64_t>(1000 + 15 * i), 7};
    reading.missions["b"] = {static_cast<uint64_t>(5 * i), 2};
    weighed = meter.Note(reading);
  }
  ASSERT_TRUE(weighed.has_value());
  EXPECT_NEAR(weighed->load.busy_processors, 2, 0.15);
  EXPECT_NEAR(weighed->load.keyframes_per_s, 4, 0.3);
  EXPECT_NEAR(weighed->load.Pressure(), 0.5, 0.05);
  EXPECT_NEAR(weighed->missions.at("a").busy_processors, 1.5, 0.15);
  EXPECT_NEAR(weighed->missions.at("b").busy_processors, 0.5, 0.1);
  EXPECT_EQ(weighed->missions.at("a").bytes, 7u);
}

TEST(LoadMeterTest, AMissionThatIsReadOrLosesKeyframesMakesNoLoad) {
  LoadMeter meter;
  LoadMeter::Reading reading = At(0, 0);
  meter.Note(reading);
  reading = At(5, 1);
  reading.missions["read"] = {100000, 0};
  EXPECT_EQ(meter.Note(reading)->load.keyframes_per_s, 0);
  reading = At(10, 2);
  reading.missions["read"] = {90000, 0};
  const auto weighed = meter.Note(reading);
  EXPECT_EQ(weighed->load.keyframes_per_s, 0);
  EXPECT_EQ(weighed->missions.at("read").busy_processors, 0);
  reading = At(15, 3);
  EXPECT_TRUE(meter.Note(reading)->missions.empty());
}

TEST(LoadMeterTest, WithoutABudgetMemoryIsNoPressure) {
  LoadMeter meter;
  LoadMeter::Reading reading = At(0, 0);
  reading.budget_bytes = 0;
  meter.Note(reading);
  reading.time += absl::Seconds(5);
  EXPECT_EQ(meter.Note(reading)->load.Pressure(), 0);
}

}  // namespace
}  // namespace corbslam::map_store
