// Tests that bits are spread.
#include "slam/util/mixed_bits.h"

#include <gtest/gtest.h>

#include <bit>

namespace corbslam {
namespace {

TEST(MixedBitsTest, IsSplitMix64) {
  // The generator's first number from seed 0, as its authors' program prints it.
  EXPECT_EQ(MixBits(kGoldenGamma), 0xe220a8397b1dcdafu);
}

TEST(MixedBitsTest, NeighboursDifferInHalfTheirBits) {
  int differ = 0;
  for (uint64_t i = 0; i < 1000; ++i) differ += std::popcount(MixBits(i) ^ MixBits(i + 1));
  EXPECT_NEAR(differ, 32'000, 500);
}

}  // namespace
}  // namespace corbslam
