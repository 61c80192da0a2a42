#include "slam/util/checksum.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "slam/util/checksum_kernels.h"

namespace corbslam {
namespace {

// The examples are those of RFC 3720, appendix B.4.
TEST(ChecksumTest, AgreesWithThePublishedExamples) {
  EXPECT_EQ(ExtendCrc32c(0, std::string(32, '\0')), 0x8a9136aau);
  EXPECT_EQ(ExtendCrc32c(0, std::string(32, '\xff')), 0x62a8ab43u);
  EXPECT_EQ(ExtendCrc32c(0, "123456789"), 0xe3069283u);
}

TEST(ChecksumTest, IsTheSameInPieces) {
  EXPECT_EQ(ExtendCrc32c(ExtendCrc32c(0, "1234567"), "89"), ExtendCrc32c(0, "123456789"));
  EXPECT_EQ(ExtendCrc32c(0, ""), 0u);
}

// Divides by the polynomial bit by bit, as the definition has it.
uint32_t Crc32cByDefinition(uint32_t state, const char* data, size_t size) {
  for (size_t i = 0; i < size; ++i) {
    state ^= static_cast<uint8_t>(data[i]);
    for (int bit = 0; bit < 8; ++bit) state = (state >> 1) ^ ((state & 1) != 0 ? 0x82f63b78u : 0u);
  }
  return state;
}

// Compares a kernel with the definition, for lengths around its words and addresses of every kind.
void ExpectFollowsTheDefinition(Crc32cKernel kernel) {
  std::mt19937_64 random(5);
  std::string bytes(300, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  for (size_t begin = 0; begin < 16; ++begin) {
    for (size_t size = 0; begin + size <= bytes.size(); size += size < 40 ? 1 : 37) {
      const auto state = static_cast<uint32_t>(random());
      ASSERT_EQ(kernel(state, bytes.data() + begin, size),
                Crc32cByDefinition(state, bytes.data() + begin, size))
          << size << " bytes from " << begin;
    }
  }
}

TEST(ChecksumTest, TablesFollowTheDefinition) { ExpectFollowsTheDefinition(&Crc32cByTables); }

TEST(ChecksumTest, InstructionsFollowTheDefinition) {
  const Crc32cKernel kernel = Crc32cByInstructions();
  if (kernel == nullptr) GTEST_SKIP() << "no instructions for CRC-32C here";
  ExpectFollowsTheDefinition(kernel);
}

}  // namespace
}  // namespace corbslam
