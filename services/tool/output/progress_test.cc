#include "services/tool/output/progress.h"

#include <gtest/gtest.h>

#include <memory>

namespace corbslam::services {
namespace {

class ProgressTest : public ::testing::Test {
 protected:
  ~ProgressTest() override { std::fclose(file_); }

  ProgressOptions Options(bool is_terminal) {
    return {.out = file_, .is_terminal = is_terminal, .is_quiet = false, .clock = [this] {
              return now_;
            }};
  }
  // Returns what was written so far.
  std::string Written() {
    std::string text(static_cast<size_t>(std::ftell(file_)), '\0');
    std::rewind(file_);
    EXPECT_EQ(std::fread(text.data(), 1, text.size(), file_), text.size());
    return text;
  }

  std::FILE* const file_ = std::tmpfile();
  absl::Time now_ = absl::FromUnixSeconds(1000);
};

TEST_F(ProgressTest, WithoutATerminalALineEveryTenSeconds) {
  {
    ProgressLine line(Options(false));
    for (int second = 0; second <= 21; ++second) {
      line.Tell(std::to_string(second) + " done");
      now_ += absl::Seconds(1);
    }
  }
  EXPECT_EQ(Written(), "progress: 10 done\nprogress: 20 done\n");
}

TEST_F(ProgressTest, ShortWorkSaysNothing) {
  {
    ProgressLine line(Options(false));
    line.Tell("1 done");
    now_ += absl::Seconds(9);
    line.Tell("2 done");
  }
  EXPECT_EQ(Written(), "");
}

TEST_F(ProgressTest, OnATerminalOneLineASecondThatGoes) {
  {
    ProgressLine line(Options(true));
    line.Tell("1 done");
    now_ += absl::Milliseconds(900);
    line.Tell("2 done");
    now_ += absl::Milliseconds(100);
    line.Tell(std::string(100, 'x'));
  }
  EXPECT_EQ(Written(), "\r1 done" + std::string(72, ' ') + "\r" + std::string(78, 'x') + "\r" +
                           std::string(78, ' ') + "\r");
}

TEST_F(ProgressTest, QuietSaysNothing) {
  {
    ProgressOptions options = Options(true);
    options.is_quiet = true;
    ProgressLine line(options);
    line.Tell("1 done");
  }
  EXPECT_EQ(Written(), "");
}

TEST_F(ProgressTest, SaysWhatIsLeftWhereThatIsKnown) {
  EXPECT_EQ(DescribeCount(12, 48, "frames", absl::Seconds(12)), "12 of 48 frames, 25 %, 36 s left");
  EXPECT_EQ(DescribeCount(0, 48, "frames", absl::Seconds(12)), "0 of 48 frames, 0 %");
  EXPECT_EQ(DescribeCount(48, 48, "frames", absl::Seconds(12)), "48 of 48 frames, 100 %");
  EXPECT_EQ(DescribeCount(12, 0, "frames", absl::Seconds(12)), "12 frames");
  EXPECT_EQ(DescribeBytes(12'000'000, 48'000'000), "12.0 MB of 48.0 MB, 25 %");
  EXPECT_EQ(DescribeBytes(12'000'000, 0), "12.0 MB");
}

}  // namespace
}  // namespace corbslam::services
