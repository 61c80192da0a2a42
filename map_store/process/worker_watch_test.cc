#include "map_store/process/worker_watch.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Lines : public google::LogSink {
 public:
  Lines() { google::AddLogSink(this); }
  ~Lines() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const google::LogMessageTime&,
            const char* message, size_t length) override {
    lines.emplace_back(message, length);
  }

  std::vector<std::string> lines;
};

class WorkerWatchTest : public ::testing::Test {
 protected:
  absl::Time now_ = absl::UnixEpoch();
  WorkerWatch watch_{[this] { return now_; }};
  Lines lines_;
};

TEST_F(WorkerWatchTest, LogsAnOutageOnceAndThenRarelyAndItsEnd) {
  EXPECT_FALSE(watch_.outage().has_value());
  for (int second = 0; second < 130; ++second) {
    watch_.Note(absl::UnavailableError("Connection refused"));
    now_ += absl::Seconds(1);
  }
  ASSERT_TRUE(watch_.outage().has_value());
  EXPECT_EQ(watch_.outage()->begin, absl::UnixEpoch());
  EXPECT_EQ(watch_.outage()->cause, "Connection refused");
  watch_.Note(absl::OkStatus());
  EXPECT_FALSE(watch_.outage().has_value());
  EXPECT_THAT(lines_.lines, ElementsAre(HasSubstr("for 0 now: Connection refused; maps are"),
                                        HasSubstr("for 1m now"), HasSubstr("again, after 2m10s")));
}

TEST_F(WorkerWatchTest, AWorkerThatRefusesOrIsCancelledIsThere) {
  watch_.Note(absl::InvalidArgumentError("no"));
  watch_.Note(absl::CancelledError("never mind"));
  EXPECT_FALSE(watch_.outage().has_value());
  watch_.Note(absl::UnavailableError("gone"));
  watch_.Note(absl::CancelledError("never mind"));
  EXPECT_TRUE(watch_.outage().has_value());
  watch_.Note(absl::InvalidArgumentError("no"));
  EXPECT_FALSE(watch_.outage().has_value());
}

}  // namespace
}  // namespace corbslam::map_store
