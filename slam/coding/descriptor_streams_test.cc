#include "slam/coding/descriptor_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "slam/coding/descriptor_model.h"
#include "slam/coding/testing/plausible_features.h"
#include "slam/util/checksum.h"

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

TEST(DescriptorModelTest, LogOddsFit) {
  std::array<int, kDescriptorBits> largest;
  for (size_t k = 0; k < kDescriptorBits; ++k) largest[k] = std::abs(kLearnedBitBias[k]);
  size_t next = 0;
  for (size_t j = 0; j < kDescriptorBits; ++j) {
    for (size_t k = j + 1; k < kDescriptorBits; ++k) {
      largest[k] += std::abs(kLearnedBitWeights[next++]);
    }
  }
  EXPECT_EQ(next, kLearnedWeights);
  EXPECT_LE(*std::ranges::max_element(largest), INT16_MAX);
}

TEST(DescriptorModelTest, WeightsAreOfBitsThatAre1) {
  const BitWeights& weights = LearnedBitWeights();
  // What a bit 1 says of the others if they are all 0 before it, by both forms.
  for (const size_t one : {0u, 100u, 254u}) {
    for (size_t k = one + 1; k < kDescriptorBits; ++k) {
      int expected = kLearnedBitBias[k];
      size_t next = 0;
      for (size_t j = 0; j < k; next += kDescriptorBits - 1 - j, ++j) {
        const int weight = kLearnedBitWeights[next + k - j - 1];
        expected += j == one ? weight : -weight;
      }
      const auto sum = static_cast<uint16_t>(weights.bias[k] + weights.after[one][k]);
      ASSERT_EQ(static_cast<int16_t>(sum), expected) << one << " " << k;
    }
    for (size_t k = 0; k <= one; ++k) ASSERT_EQ(weights.after[one][k], 0) << one << " " << k;
  }
}

TEST(DescriptorModelTest, ProbabilitiesGrowWithTheLogOddsAndLeaveBothPossible) {
  const auto probability_of = [](int odds) -> uint32_t {
    return ProbabilitiesOfLogOdds()[static_cast<uint16_t>(odds)];
  };
  EXPECT_EQ(probability_of(0), 32768u);
  EXPECT_NEAR(probability_of(kLogOddsSteps), 65536 / (1 + std::exp(-1.0)), 2);
  for (int odds = -INT16_MAX; odds < INT16_MAX; ++odds) {
    ASSERT_LE(probability_of(odds), probability_of(odds + 1));
    ASSERT_EQ(probability_of(odds) + probability_of(-odds), 65536u);
    ASSERT_GE(probability_of(odds), 1u);
    ASSERT_LE(probability_of(odds), 65535u);
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

// The checksum was taken on x86-64 with AVX2: a robot of another kind must write the bytes that a
// server reads.
TEST(DescriptorStreamsTest, BytesAreTheSameOnEveryProcessor) {
  uint32_t checksum = 0;
  for (const std::string& stream : EncodeDescriptors(RandomDescriptors(203))) {
    checksum = ExtendCrc32c(checksum, stream);
  }
  EXPECT_EQ(checksum, 0x44a7fc01u);
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
