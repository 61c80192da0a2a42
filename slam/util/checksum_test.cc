#include "slam/util/checksum.h"

#include <gtest/gtest.h>

#include <string>

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

}  // namespace
}  // namespace corbslam
