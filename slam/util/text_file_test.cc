#include "slam/util/text_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <utility>

namespace corbslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

std::vector<std::pair<int, std::string>> ReadLines(const std::string& text, absl::Status& status) {
  const std::string path = ::testing::TempDir() + "/text_file_test.txt";
  std::ofstream(path, std::ios::binary) << text;
  std::vector<std::pair<int, std::string>> lines;
  status = ForEachLine(path, [&](int line, absl::string_view content) {
    lines.emplace_back(line, std::string(content));
    return absl::OkStatus();
  });
  return lines;
}

TEST(ForEachLineTest, TakesWhatEditorsWrite) {
  absl::Status status;
  EXPECT_THAT(ReadLines("\xef\xbb\xbf# heading\r\n\t1 a.png\r\n\r\n2\tb#1.png # last\n", status),
              ElementsAre(Pair(2, "1 a.png"), Pair(4, "2\tb#1.png")));
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_THAT(ReadLines("1 a\r2 b\r", status), ElementsAre(Pair(1, "1 a"), Pair(2, "2 b")));
  EXPECT_THAT(ReadLines("1 a\n2 b", status), ElementsAre(Pair(1, "1 a"), Pair(2, "2 b")));
}

TEST(ForEachLineTest, RefusesUtf16) {
  absl::Status status;
  EXPECT_THAT(ReadLines("\xff\xfe"
                        "1",
                        status),
              ElementsAre());
  EXPECT_THAT(std::string(status.message()), HasSubstr("text_file_test.txt:1: is UTF-16 text"));
}

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
