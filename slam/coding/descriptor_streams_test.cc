#include "slam/coding/descriptor_streams.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "slam/coding/descriptor_model.h"
#include "slam/coding/testing/plausible_features.h"

namespace corbslam {
namespace {

using Streams = std::array<std::string, kDescriptorStreams>;

std::array<std::string_view, kDescriptorStreams> Views(const Streams& streams) {
  return {streams[0], streams[1], streams[2], streams[3]};
}

size_t SizeOf(const Streams& streams) {
  size_t size = 0;
  for (const std::string& stream : streams) size += stream.size();
  return size;
}

std::vector<Descriptor> RandomDescriptors(size_t count) {
  std::mt19937_64 random(1);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (uint64_t& word : descriptor.words) word = random();
  }
  return descriptors;
}

TEST(DescriptorModelTest, SumsOfWeightsFit) {
  const BitWeights& weights = LearnedBitWeights();
  for (size_t k = 0; k < kDescriptorBits; ++k) {
    int largest = std::abs(weights.bias[k]);
    for (size_t j = 0; j < kDescriptorBits; ++j) {
      if (j >= k) {
        EXPECT_EQ(weights.after[j][k], 0) << j << " " << k;
      }
      largest += std::abs(weights.after[j][k]);
    }
    EXPECT_LE(largest, 32767) << k;
  }
}

TEST(DescriptorModelTest, ProbabilitiesGrowWithTheLogOddsAndLeaveBothPossible) {
  EXPECT_EQ(ProbabilityOf(0), 32768u);
  EXPECT_NEAR(ProbabilityOf(kLogOddsSteps), 65536 / (1 + std::exp(-1.0)), 2);
  for (int odds = -2000; odds < 2000; ++odds) {
    EXPECT_LE(ProbabilityOf(odds), ProbabilityOf(odds + 1));
    EXPECT_EQ(ProbabilityOf(odds) + ProbabilityOf(-odds), 65536u);
    EXPECT_GE(ProbabilityOf(odds), 1u);
    EXPECT_LE(ProbabilityOf(odds), 65535u);
  }
}

TEST(DescriptorStreamsTest, AnyDescriptorsComeBack) {
  for (const size_t count : {0u, 1u, 3u, 4u, 5u, 2000u}) {
    const std::vector<Descriptor> descriptors = RandomDescriptors(count);
    std::vector<Descriptor> read(count);
    EXPECT_TRUE(DecodeDescriptors(Views(EncodeDescriptors(descriptors)), read)) << count;
    EXPECT_EQ(read, descriptors) << count;
  }
}

TEST(DescriptorStreamsTest, CornersTakeAboutHalfOfTheirBits) {
  const std::vector<Descriptor> descriptors =
      testing::MakePlausibleFeatures(1, 2000, {1241, 376}).descriptors;
  EXPECT_LT(SizeOf(EncodeDescriptors(descriptors)), 2000u * 20);
}

TEST(DescriptorStreamsTest, EveryInstructionSetSaysTheSame) {
  std::vector<Descriptor> descriptors =
      testing::MakePlausibleFeatures(2, 501, {640, 480}).descriptors;
  const std::vector<Descriptor> others = RandomDescriptors(50);
  descriptors.insert(descriptors.end(), others.begin(), others.end());
  const Streams streams = EncodeDescriptors(descriptors);
  EXPECT_EQ(streams, EncodeDescriptorsPortably(descriptors));
  std::vector<Descriptor> read(descriptors.size());
  EXPECT_TRUE(DecodeDescriptorsPortably(Views(streams), read));
  EXPECT_EQ(read, descriptors);
}

TEST(DescriptorStreamsTest, FewerThanWereWrittenShow) {
  const Streams streams = EncodeDescriptors(RandomDescriptors(100));
  for (const size_t count : {0u, 50u, 99u}) {
    std::vector<Descriptor> read(count);
    EXPECT_FALSE(DecodeDescriptors(Views(streams), read)) << count;
  }
}

}  // namespace
}  // namespace corbslam
