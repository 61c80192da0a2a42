#include "services/security/audit_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

using nlohmann::json;

constexpr char kDeletion[] = "corbslam.v1.MapStore/DeleteMission";
const absl::Time kMoment = absl::FromUnixSeconds(1'800'000'000);

TEST(RefusalTest, IsWhatWasNotAllowedOrTooMuch) {
  constexpr char kSync[] = "corbslam.v1.MapStore/Sync";
  using Code = absl::StatusCode;
  EXPECT_EQ(RefusalOf(kDeletion, Code::kOk), std::nullopt);
  EXPECT_EQ(RefusalOf(kDeletion, Code::kNotFound), std::nullopt);
  EXPECT_EQ(RefusalOf(kDeletion, Code::kInvalidArgument), std::nullopt);
  EXPECT_EQ(RefusalOf(kSync, Code::kInvalidArgument), RefusalKind::kInvalidSession);
  EXPECT_EQ(RefusalOf(kSync, Code::kUnavailable), std::nullopt);
  EXPECT_EQ(RefusalOf(kDeletion, Code::kPermissionDenied), RefusalKind::kPermissionDenied);
  EXPECT_EQ(RefusalOf(kDeletion, Code::kUnauthenticated), RefusalKind::kUnauthenticated);
  EXPECT_EQ(RefusalOf(kDeletion, Code::kResourceExhausted), RefusalKind::kResourceExhausted);
}

TEST(RefusalLimiterTest, CountsWhatItLeavesOut) {
  RefusalLimiter limiter(2);
  int written = 0;
  for (int i = 0; i < 10; ++i) written += limiter.Admit("a", kMoment);
  EXPECT_EQ(written, 2);
  EXPECT_TRUE(limiter.Admit("b", kMoment)) << "one peer's flood hides no other peer";
  EXPECT_TRUE(limiter.TakeOver(kMoment + absl::Seconds(59)).empty());
  const auto over = limiter.TakeOver(kMoment + absl::Minutes(1));
  ASSERT_EQ(over.size(), 1u);
  EXPECT_EQ(over[0].peer, "a");
  EXPECT_EQ(over[0].count, 8u);
  EXPECT_TRUE(limiter.Admit("a", kMoment + absl::Minutes(1)));
}

TEST(RefusalLimiterTest, ManyPeersShareALimit) {
  RefusalLimiter limiter(1);
  int written = 0;
  for (int i = 0; i < 10'000; ++i) written += limiter.Admit(absl::StrCat("peer", i), kMoment);
  EXPECT_LE(written, 201);
  uint64_t left_out = 0;
  for (const auto& over : limiter.TakeOver(kMoment + absl::Minutes(1))) left_out += over.count;
  EXPECT_EQ(left_out, 10'000u - static_cast<uint64_t>(written));
}

class AuditLogTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + "/corbslam_audit_XXXXXX";
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
    options_.file = folder_ + "/audit.log";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::shared_ptr<AuditLog> Open() {
    auto log = AuditLog::Open(options_, std::make_shared<AccessControl>(AccessControlOptions()));
    EXPECT_TRUE(log.ok()) << log.status();
    return *log;
  }
  // Returns the file's lines; each must be JSON.
  std::vector<json> Lines() const {
    std::ifstream file(options_.file);
    std::vector<json> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(json::parse(line));
    return lines;
  }
  static void TurnAway(AuditLog& log, const std::string& method, const std::string& user_agent) {
    log.OnTurnedAway(method, {{"corbslam:missions/lab/viewers/eve"}, {}}, user_agent,
                     absl::PermissionDeniedError("missions/lab/viewers/eve may not"));
  }

  std::string folder_;
  AuditLogOptions options_;
};

TEST_F(AuditLogTest, SaysWhoWasRefusedWhat) {
  TurnAway(*Open(), kDeletion, "grpc-c++/1.51.1");
  const std::vector<json> lines = Lines();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["event"], "refused");
  EXPECT_EQ(lines[0]["identity"], "missions/lab/viewers/eve");
  EXPECT_EQ(lines[0]["call"], kDeletion);
  EXPECT_EQ(lines[0]["code"], "PERMISSION_DENIED");
  EXPECT_EQ(lines[0]["message"], "missions/lab/viewers/eve may not");
  EXPECT_EQ(lines[0]["user_agent"], "grpc-c++/1.51.1");
}

TEST_F(AuditLogTest, SaysWhatTheServerDidByItself) {
  Open()->OnOwnDoing("mission_expired", "missions/lab", "nobody has used it");
  const std::vector<json> lines = Lines();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["event"], "mission_expired");
  EXPECT_EQ(lines[0]["resource"], "missions/lab");
  EXPECT_EQ(lines[0]["message"], "nobody has used it");
  EXPECT_TRUE(lines[0].contains("time"));
  EXPECT_FALSE(lines[0].contains("identity"));
}

TEST_F(AuditLogTest, WhatCallersSayIsOneLineWhateverItIs) {
  constexpr char kHostile[] = "\"}\n{\"event\":\"administered\", \x1b[2J\0\xff\xe2\x80\xa8";
  const std::string hostile =
      std::string(kHostile, sizeof(kHostile) - 1) + std::string(10'000, 'x');
  TurnAway(*Open(), hostile, hostile);
  const std::vector<json> lines = Lines();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["event"], "refused");
  EXPECT_LT(lines[0].dump().size(), 1500u);
}

TEST_F(AuditLogTest, AFloodIsAFewLinesAndANumber) {
  options_.refusals_a_minute = 5;
  const uint64_t refused = ProcessAuditCounts().refused[1];
  {
    const auto log = Open();
    for (int i = 0; i < 1000; ++i) TurnAway(*log, kDeletion, "");
  }
  const std::vector<json> lines = Lines();
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[5]["event"], "left_out");
  EXPECT_EQ(lines[5]["refusals"], 995);
  EXPECT_EQ(ProcessAuditCounts().refused[1] - refused, 1000u);
}

TEST_F(AuditLogTest, AFullDiskIsCounted) {
  options_.file = "/dev/full";
  const uint64_t failed = ProcessAuditCounts().failed;
  TurnAway(*Open(), kDeletion, "");
  EXPECT_EQ(ProcessAuditCounts().failed - failed, 1u);
}

TEST_F(AuditLogTest, WithoutAFileRefusalsAreCountedAlone) {
  options_.file = "";
  const uint64_t refused = ProcessAuditCounts().refused[1];
  const uint64_t written = ProcessAuditCounts().written;
  TurnAway(*Open(), kDeletion, "");
  EXPECT_EQ(ProcessAuditCounts().refused[1] - refused, 1u);
  EXPECT_EQ(ProcessAuditCounts().written, written);
}

}  // namespace
}  // namespace corbslam::services
