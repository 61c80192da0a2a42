#include "slam/coding/binary_coder.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "slam/coding/adaptive_models.h"

namespace corbslam {
namespace {

struct CodedBit {
  uint32_t one_in_65536;
  bool bit;
};

// Some of the bits were all but impossible.
std::vector<CodedBit> MakeBits(int count) {
  std::mt19937 random(1);
  std::vector<CodedBit> bits;
  for (int i = 0; i < count; ++i) {
    const auto any = static_cast<uint32_t>(1 + random() % 65535);
    const uint32_t extreme = any % 2 == 0 ? 1 : 65535;
    const uint32_t chance = random() % 4 == 0 ? extreme : any;
    bits.push_back({chance, random() % 3 == 0});
  }
  return bits;
}

std::string Write(const std::vector<CodedBit>& bits) {
  BitWriter writer;
  for (const CodedBit& bit : bits) writer.Bit(bit.one_in_65536, bit.bit);
  return writer.Finish();
}

TEST(BinaryCoderTest, EveryBitComesBackAndAllIsRead) {
  for (const int count : {0, 1, 2, 31, 1000, 100'000}) {
    const std::vector<CodedBit> bits = MakeBits(count);
    const std::string bytes = Write(bits);
    BitReader reader(bytes);
    for (const CodedBit& bit : bits) ASSERT_EQ(reader.Bit(bit.one_in_65536), bit.bit) << count;
    EXPECT_TRUE(reader.done()) << count;
    EXPECT_FALSE(reader.exhausted()) << count;
  }
}

TEST(BinaryCoderTest, WhatIsMissingOrTooMuchShows) {
  const std::vector<CodedBit> bits = MakeBits(1000);
  const std::string bytes = Write(bits);
  for (const std::string& wrong :
       {bytes.substr(0, bytes.size() - 4), bytes.substr(0, bytes.size() - 1), bytes + "more",
        bytes + "x", std::string()}) {
    BitReader reader(wrong);
    bool same = true;
    for (const CodedBit& bit : bits) same &= reader.Bit(bit.one_in_65536) == bit.bit;
    // Wrong bits may come to the right length.
    EXPECT_FALSE(same && reader.done()) << wrong.size();
  }
}

TEST(BinaryCoderTest, LikelyBitsCostNearlyNothing) {
  BitWriter writer;
  for (int i = 0; i < 10'000; ++i) writer.Bit(65000, true);
  // The code's ideal length is 10,000 * log2(65536 / 65000) = 118 bits.
  EXPECT_LE(writer.Finish().size(), 20u);
}

TEST(AdaptiveModelsTest, EveryNumberComesBack) {
  const std::vector<int32_t> differences = {0,
                                            1,
                                            -1,
                                            2,
                                            300,
                                            -70'000,
                                            0,
                                            0,
                                            std::numeric_limits<int32_t>::max(),
                                            std::numeric_limits<int32_t>::min()};
  const std::vector<uint32_t> numbers = {0, 1, 2, 255, 65536, 1u << 31, 0xfffffffdu};
  BitWriter writer;
  {
    DifferenceModel difference;
    SmallNumberModel number;
    BitsModel<3> bits;
    for (const int32_t value : differences) difference.Code(writer, value);
    for (const uint32_t value : numbers) number.Code(writer, value);
    for (uint32_t value = 0; value < 32; ++value) bits.Code(writer, 5, value);
  }
  const std::string bytes = writer.Finish();
  BitReader reader(bytes);
  // The values that the reader is given play no part.
  DifferenceModel difference;
  SmallNumberModel number;
  BitsModel<3> bits;
  for (const int32_t value : differences) EXPECT_EQ(difference.Code(reader, 0), value);
  for (const uint32_t value : numbers) EXPECT_EQ(number.Code(reader, 0), value);
  for (uint32_t value = 0; value < 32; ++value) EXPECT_EQ(bits.Code(reader, 5, 0), value);
  EXPECT_TRUE(reader.done());
}

}  // namespace
}  // namespace corbslam
