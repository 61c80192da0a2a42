#include "slam/features/keypoint.h"

#include <gtest/gtest.h>

#include <random>

namespace corbslam {
namespace {

// Counts bit by bit, whatever the processor has.
int CountDiffering(const Descriptor& a, const Descriptor& b) {
  int count = 0;
  for (size_t bit = 0; bit < 256; ++bit) {
    count += static_cast<int>(((a.words[bit / 64] ^ b.words[bit / 64]) >> (bit % 64)) & 1);
  }
  return count;
}

TEST(HammingDistanceTest, CountsDifferingBits) {
  std::mt19937_64 random(7);
  Descriptor a;
  Descriptor b;
  for (int i = 0; i < 1000; ++i) {
    for (uint64_t& word : a.words) word = random();
    for (uint64_t& word : b.words) word = random();
    ASSERT_EQ(HammingDistance(a, b), CountDiffering(a, b)) << i;
  }
}

TEST(HammingDistanceTest, IsExactAtItsEnds) {
  Descriptor all;
  all.words.fill(~uint64_t{0});
  EXPECT_EQ(HammingDistance(all, all), 0);
  EXPECT_EQ(HammingDistance(all, {}), 256);
  for (size_t bit = 0; bit < 256; ++bit) {
    Descriptor one;
    one.words[bit / 64] = uint64_t{1} << (bit % 64);
    EXPECT_EQ(HammingDistance(one, {}), 1) << bit;
    EXPECT_EQ(HammingDistance(one, all), 255) << bit;
  }
}

}  // namespace
}  // namespace corbslam
