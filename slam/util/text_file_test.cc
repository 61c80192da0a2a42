#include "slam/util/text_file.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

TEST(ParseSecondsTest, KeepsEveryDigitOfAPlainDecimal) {
  EXPECT_EQ(*ParseSeconds("1305031102.175304"), 1305031102175304000);
  EXPECT_EQ(*ParseSeconds(" 0.000000001 "), 1);
  EXPECT_EQ(*ParseSeconds("12"), 12'000'000'000);
}

TEST(ParseSecondsTest, ReadsExponentsToTheNearest) {
  EXPECT_EQ(*ParseSeconds("1.037359e-01"), 103735900);
  EXPECT_EQ(*ParseSeconds("-2.5"), -2'500'000'000);
}

TEST(ParseSecondsTest, RefusesWhatIsNoTime) {
  for (const char* text : {"", "abc", "1.2.3", "nan", "inf", "1e30", "99999999999"}) {
    EXPECT_EQ(ParseSeconds(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(FormatSecondsTest, IsTheInverse) {
  for (const int64_t time_ns : {0L, 1L, -2'500'000'000L, 1305031102175304000L}) {
    EXPECT_EQ(*ParseSeconds(FormatSeconds(time_ns)), time_ns);
  }
}

}  // namespace
}  // namespace corbslam
