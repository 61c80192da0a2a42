// Tests which flags a program starts with, and what it says of the others.
#include "services/security/security_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "services/security/testing/test_certificates.h"

namespace corbslam::services {
namespace {

using test_data::TestCertificates;
using ::testing::HasSubstr;

class SecurityOptionsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { certificates_ = new TestCertificates("lab"); }
  static void TearDownTestSuite() { delete certificates_; }

  static std::string WriteFile(const std::string& name, const std::string& text) {
    const std::string path = certificates_->Path(name);
    std::ofstream(path) << text;
    return path;
  }

  static TestCertificates* certificates_;
};
TestCertificates* SecurityOptionsTest::certificates_ = nullptr;

TEST_F(SecurityOptionsTest, ProgramsStartWithCertificatesOrInsecurelyByName) {
  SecurityOptions insecure;
  insecure.insecure = true;
  const auto open = MakeServerSecurity(insecure);
  ASSERT_TRUE(open.ok()) << open.status();
  EXPECT_EQ(open->access, nullptr);
  EXPECT_TRUE(MakeChannelCredentials(insecure).ok());

  const auto secure = MakeServerSecurity(certificates_->Options("store"));
  ASSERT_TRUE(secure.ok()) << secure.status();
  EXPECT_NE(secure->access, nullptr);
  EXPECT_TRUE(MakeChannelCredentials(certificates_->Options("alpha")).ok());
}

TEST_F(SecurityOptionsTest, AServerSaysWhatIsMissing) {
  const auto complaint = [](const std::function<void(SecurityOptions&)>& change) {
    SecurityOptions options = certificates_->Options("store");
    change(options);
    const absl::Status status = MakeServerSecurity(options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(complaint([](auto& options) { options = {}; }), HasSubstr("or --insecure"));
  EXPECT_THAT(complaint([](auto& options) { options.key_file = ""; }),
              HasSubstr("needs --tls-cert and --tls-key"));
  EXPECT_THAT(complaint([](auto& options) { options.ca_file = ""; }),
              HasSubstr("needs to know who calls: --tls-ca"));
  EXPECT_THAT(complaint([](auto& options) { options.insecure = true; }),
              HasSubstr("--insecure excludes --tls-cert"));
  EXPECT_THAT(complaint([](auto& options) { options.certificate_file = "/nowhere"; }),
              HasSubstr("--tls-cert /nowhere can't be read"));
  EXPECT_THAT(
      complaint([](auto& options) { options.key_file = certificates_->Path("worker.key"); }),
      HasSubstr("worker.key does not belong to"));
  EXPECT_THAT(complaint([](auto& options) { options.ca_file = options.key_file; }),
              HasSubstr("store.key holds no certificate"));
  EXPECT_THAT(complaint([](auto& options) { options.key_file = WriteFile("junk.key", "junk"); }),
              HasSubstr("junk.key holds no private key"));
  EXPECT_THAT(
      complaint([](auto& options) { options.token_key_file = certificates_->Path("token.key"); }),
      HasSubstr("there is no Ed25519 public key"));
}

TEST_F(SecurityOptionsTest, CheckingMakesNoAuditLog) {
  SecurityOptions options = certificates_->Options("store");
  options.audit_file = certificates_->Path("audit.log");
  EXPECT_TRUE(CheckServerSecurity(options).ok());
  EXPECT_FALSE(std::ifstream(options.audit_file).is_open());
  options.audit_file = certificates_->Path("none/audit.log");
  for (const absl::Status& status :
       {CheckServerSecurity(options), MakeServerSecurity(options).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("--audit-log"));
  }
}

TEST_F(SecurityOptionsTest, WhatIsSaidOfTokensNeedsTheirKeys) {
  SecurityOptions options = certificates_->Options("store");
  options.audience = "north";
  EXPECT_THAT(std::string(MakeServerSecurity(options).status().message()),
              HasSubstr("need --token-key"));
  options.token_key_file = certificates_->Path("token.pub");
  EXPECT_TRUE(MakeServerSecurity(options).ok());
  options.audience = "two words";
  EXPECT_THAT(std::string(MakeServerSecurity(options).status().message()),
              HasSubstr("--token-audience is \"two words\""));
  options.audience = "";
  options.revoked_file = WriteFile("revoked.txt", "fine\nnot fine\n");
  EXPECT_THAT(std::string(MakeServerSecurity(options).status().message()),
              HasSubstr("revoked.txt: line 2: a token's id is \"not fine\""));
}

TEST_F(SecurityOptionsTest, AClientSaysWhatIsMissing) {
  const auto complaint = [](const std::function<void(SecurityOptions&)>& change) {
    SecurityOptions options = certificates_->Options("alpha");
    change(options);
    const absl::Status status = MakeChannelCredentials(options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(complaint([](auto& options) { options = {}; }), HasSubstr("or --insecure"));
  EXPECT_THAT(complaint([](auto& options) { options.key_file = ""; }),
              HasSubstr("--tls-cert and --tls-key go together"));
  EXPECT_THAT(complaint([](auto& options) { options.token_file = "/nowhere"; }),
              HasSubstr("--token-file /nowhere can't be read"));
}

TEST_F(SecurityOptionsTest, WithInsecureNobodyHasAnIdentityThatClosedHealthCouldAskFor) {
  SecurityOptions options;
  options.insecure = true;
  options.health_is_open = false;
  const auto closed = MakeServerSecurity(options);
  ASSERT_TRUE(closed.ok()) << closed.status();
  EXPECT_FALSE(closed->server.health);
}

}  // namespace
}  // namespace corbslam::services
