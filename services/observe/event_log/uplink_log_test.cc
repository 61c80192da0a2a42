#include "services/observe/event_log/uplink_log.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "slam/exchange/session_end.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr absl::Duration kPatience = absl::Seconds(20);

// Collects what is logged of robots.
class Lines : public google::LogSink {
 public:
  Lines() { google::AddLogSink(this); }
  ~Lines() override { google::RemoveLogSink(this); }

  void send(google::LogSeverity, const char*, const char*, int, const google::LogMessageTime&,
            const char* message, size_t length) override {
    absl::MutexLock lock(&mutex_);
    lines_.emplace_back(message, length);
  }
  // Waits until there are `count` lines, and returns them.
  std::vector<std::string> WaitFor(size_t count) {
    absl::MutexLock lock(&mutex_);
    const auto come = [this, count]()
                          ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return lines_.size() >= count; };
    EXPECT_TRUE(mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience));
    lines_.resize(std::max(lines_.size(), count));
    return lines_;
  }

 private:
  absl::Mutex mutex_;
  std::vector<std::string> lines_ ABSL_GUARDED_BY(mutex_);
};

class UplinkLogTest : public ::testing::Test {
 protected:
  absl::Status Explain(const absl::Status& seen) {
    absl::MutexLock lock(&mutex_);
    ++explained_;
    return cause_.ok() ? seen : cause_;
  }
  void SetCause(const absl::Status& cause) {
    absl::MutexLock lock(&mutex_);
    cause_ = cause;
  }
  void Fail(const absl::Status& reason) {
    log_.OnOpening();
    log_.OnClosed(reason);
  }
  void Advance(absl::Duration duration) {
    absl::MutexLock lock(&mutex_);
    now_ += duration;
  }
  int explained() {
    absl::MutexLock lock(&mutex_);
    return explained_;
  }
  static UplinkLogOptions Options(UplinkLogTest* test) {
    UplinkLogOptions options;
    options.slow_attempt = absl::Milliseconds(1);
    options.clock = [test] {
      absl::MutexLock lock(&test->mutex_);
      return test->now_;
    };
    return options;
  }

  absl::Mutex mutex_;
  absl::Status cause_ ABSL_GUARDED_BY(mutex_);
  absl::Time now_ ABSL_GUARDED_BY(mutex_) = absl::UnixEpoch();
  int explained_ ABSL_GUARDED_BY(mutex_) = 0;
  Lines lines_;
  UplinkLog log_{{.mission = "lab", .agent = "alpha"},
                 [this](const absl::Status& seen) { return Explain(seen); },
                 Options(this)};
};

TEST_F(UplinkLogTest, SaysTheCauseOnceAndWhenItIsOver) {
  SetCause(absl::UnavailableError("Connection refused"));
  for (int i = 0; i < 5; ++i) Fail(absl::UnavailableError("gRPC's words"));
  EXPECT_THAT(
      lines_.WaitFor(1)[0],
      AllOf(HasSubstr("mission=lab agent=alpha no session with the map store"),
            HasSubstr("Connection refused"), HasSubstr("maps on"), HasSubstr("tries again")));
  EXPECT_EQ(log_.status(), absl::UnavailableError("Connection refused"));
  Advance(absl::Seconds(34));
  log_.OnOpening();
  log_.OnOpened();
  EXPECT_THAT(lines_.WaitFor(2)[1], HasSubstr("stands again, after 34s"));
  EXPECT_EQ(log_.status(), absl::OkStatus());
  EXPECT_EQ(lines_.WaitFor(2).size(), 2u);
}

TEST_F(UplinkLogTest, LooksIntoAnAttemptThatDoesNotEnd) {
  SetCause(absl::UnavailableError("looking up store.lan takes longer than 1s"));
  log_.OnOpening();
  EXPECT_THAT(lines_.WaitFor(1)[0], HasSubstr("store.lan takes longer"));
}

TEST_F(UplinkLogTest, SaysAnotherCauseAndRemindsRarely) {
  SetCause(absl::UnavailableError("first"));
  Fail(absl::UnavailableError("x"));
  lines_.WaitFor(1);
  SetCause(absl::UnavailableError("second"));
  Advance(absl::Seconds(20));
  Fail(absl::UnavailableError("x"));
  EXPECT_THAT(lines_.WaitFor(2)[1], HasSubstr("second"));
  Advance(absl::Minutes(1));
  Fail(absl::UnavailableError("x"));
  EXPECT_THAT(lines_.WaitFor(3)[2], HasSubstr("since 1m20s"));
}

// A robot that only localises has no map of its own to go on with.
TEST_F(UplinkLogTest, OneThatOnlyLocalisesMapsNothingOn) {
  UplinkLogOptions options;
  options.localise_only = true;
  UplinkLog log(
      {.mission = "labb", .agent = "beta"},
      [this](const absl::Status& seen) { return Explain(seen); }, options);
  SetCause(absl::NotFoundError("there is no mission labb"));
  log.OnOpening();
  log.OnClosed(absl::NotFoundError("there is no mission labb"));
  EXPECT_THAT(
      lines_.WaitFor(1)[0],
      AllOf(HasSubstr("there is no mission labb"), HasSubstr("only localises"),
            HasSubstr("it is lost"), HasSubstr("Is --mission right?"), Not(HasSubstr("maps on"))));
  log.OnOpening();
  log.OnOpened();
  lines_.WaitFor(2);
  SetCause(absl::UnavailableError("Connection refused"));
  log.OnClosed(absl::UnavailableError("x"));
  EXPECT_THAT(lines_.WaitFor(3)[2],
              AllOf(HasSubstr("localises on in what it was told"), Not(HasSubstr("maps on"))));
}

TEST_F(UplinkLogTest, SaysThatAFencedRobotAsksAgainRarely) {
  log_.OnOpening();
  log_.OnOpened();
  log_.OnClosed(absl::AbortedError("a newer session"));
  EXPECT_THAT(lines_.WaitFor(2)[1],
              AllOf(HasSubstr("a newer session"), HasSubstr("asks again every two minutes")));
}

TEST_F(UplinkLogTest, SaysThatAMissionThatWasDeletedIsNotTriedAgain) {
  log_.OnOpening();
  log_.OnOpened();
  log_.OnClosed(MissionDeletedError("lab"));
  EXPECT_THAT(lines_.WaitFor(2)[1],
              AllOf(HasSubstr("mission lab was deleted"), HasSubstr("does not try again")));
}

// A store grants a session each four seconds, and ends it at once.
TEST_F(UplinkLogTest, SessionsThatDoNotLastAreToldRarely) {
  SetCause(absl::UnavailableError("the disk is full"));
  for (int i = 0; i < 20; ++i) {
    log_.OnOpening();
    log_.OnOpened();
    log_.OnClosed(absl::UnavailableError("x"));
    // The cause is found by the log's own thread.
    absl::SleepFor(absl::Milliseconds(20));
    Advance(absl::Seconds(4));
  }
  const std::vector<std::string> lines = lines_.WaitFor(3);
  EXPECT_LE(lines.size(), 14u);
  EXPECT_THAT(lines, Each(Not(AnyOf(HasSubstr("since 0"), HasSubstr("after 0")))));
  EXPECT_THAT(lines, Contains(HasSubstr("no session with the map store any more")));
  EXPECT_THAT(lines, Contains(HasSubstr("sessions in a row ended within 15s")));
}

TEST_F(UplinkLogTest, IsNotConnectedBeforeTheFirstSession) {
  EXPECT_TRUE(absl::IsUnavailable(log_.status()));
  log_.OnOpening();
  log_.OnOpened();
  EXPECT_THAT(lines_.WaitFor(1)[0], HasSubstr("a session with the map store stands"));
  EXPECT_TRUE(log_.status().ok());
}

}  // namespace
}  // namespace corbslam::services
