#include "services/tool/rig/pair_regions.h"

#include <gtest/gtest.h>

#include <variant>

#include "client_agent/source_checks/testing/layered_scene.h"
#include "client_agent/source_checks/testing/sample_source.h"

namespace corbslam::services {

using client_agent::LayeredStereo;
using client_agent::PairPreparation;
using client_agent::SampleSource;
using client_agent::TakeSample;

namespace {

PairRegions Measure(const std::string& damage, double amount) {
  const SampleSource source = LayeredStereo();
  const auto sample = TakeSample(source, damage, amount);
  EXPECT_TRUE(sample.ok()) << sample.status();
  const auto preparation = PairPreparation::Make(std::get<StereoCalibration>(source.calibration));
  EXPECT_TRUE(preparation.ok()) << preparation.status();
  return MeasureRegions(*preparation, preparation->Judge(*sample));
}

TEST(PairRegionsTest, RowsOfAGoodPairAgreeEverywhere) {
  const PairRegions measured = Measure("", 0);
  EXPECT_GT(measured.pairs, 0u);
  EXPECT_GT(measured.all.matches, 300u);
  EXPECT_LT(measured.all.row_error_px, 0.5);
  for (const RegionRows& region : measured.regions) EXPECT_LT(region.row_error_px, 0.6);
  EXPECT_LT(measured.negative_share, 0.05);
  EXPECT_NEAR(measured.low_disparity_px, 4, 1.5);
  EXPECT_NEAR(measured.high_disparity_px, 40, 8);
}

TEST(PairRegionsTest, SaysByHowMuchAndInWhichDirectionRowsAreApart) {
  const PairRegions measured = Measure("rows", 2);
  EXPECT_NEAR(measured.all.row_offset_px, 2, 0.3);
  EXPECT_NEAR(measured.all.row_error_px, 2, 0.3);
}

// A right camera that is turned about its axis is higher on one side and lower on the other.
TEST(PairRegionsTest, RegionsShowARolledCamera) {
  const PairRegions measured = Measure("roll", 1);
  const double left = measured.regions[3].row_offset_px;
  const double right = measured.regions[5].row_offset_px;
  EXPECT_GT(std::abs(left - right), 4);
  EXPECT_LT(left * right, 0);
}

TEST(PairRegionsTest, ExchangedCamerasHaveTheWrongSign) {
  EXPECT_GT(Measure("exchanged", 0).negative_share, 0.8);
}

}  // namespace
}  // namespace corbslam::services
