#include "services/security/certificate_checks.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "absl/time/clock.h"
#include "services/security/testing/test_certificates.h"

namespace corbslam::services {
namespace {

using test_data::TestCertificates;

// Returns the level of the finding that says it.
Level LevelOf(const Findings& findings, const std::string& text) {
  for (const Finding& finding : findings) {
    if (finding.text.find(text) != std::string::npos) return finding.level;
  }
  ADD_FAILURE() << "nothing of \"" << text << "\" in\n" << FormatFindings(findings);
  return Level::kOk;
}

std::string Read(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class CertificateChecksTest : public ::testing::Test {
 protected:
  const TestCertificates certificates_{"lab", "store.lan"};
  const TestCertificates others_{"lab"};
  SecurityOptions options_ = certificates_.Options("alpha");
};

TEST_F(CertificateChecksTest, GoodFilesAreSaidToBeGoodOneByOne) {
  const Findings findings = CheckSecurityFiles(options_, absl::Now());
  EXPECT_FALSE(AnyFailed(findings)) << FormatFindings(findings);
  EXPECT_EQ(LevelOf(findings, "issued by an authority"), Level::kOk);
  // The authority's own end, the certificate's, and the chain between them.
  EXPECT_EQ(findings.size(), 3u) << FormatFindings(findings);
}

TEST_F(CertificateChecksTest, ACertificateIsGoodFromItsFirstDayToItsLast) {
  const absl::Time now = absl::Now();
  const auto at = [&](absl::Duration later) { return CheckSecurityFiles(options_, now + later); };
  EXPECT_EQ(LevelOf(at(absl::Hours(24 * 20)), "expires at"), Level::kWarn);
  EXPECT_EQ(LevelOf(at(absl::Hours(24 * 40)), "expired at"), Level::kFail);
  EXPECT_EQ(LevelOf(at(-absl::Hours(24)), "is good from"), Level::kFail);
}

TEST_F(CertificateChecksTest, OfSeveralTheOneThatEndsFirstCounts) {
  const std::string both =
      Read(certificates_.Path("ca.pem")) + Read(certificates_.Path("alpha.pem"));
  const absl::Time later = absl::Now() + absl::Hours(24 * 40);
  EXPECT_EQ(CheckExpiry("x", both, later).text,
            CheckExpiry("x", Read(certificates_.Path("alpha.pem")), later).text);
  EXPECT_EQ(CheckExpiry("x", "no certificate", absl::Now()).level, Level::kFail);
}

TEST_F(CertificateChecksTest, ACertificateOfAnotherAuthorityFails) {
  options_.ca_file = others_.Path("ca.pem");
  EXPECT_EQ(LevelOf(CheckSecurityFiles(options_, absl::Now()), "does not lead to an authority"),
            Level::kFail);
}

TEST_F(CertificateChecksTest, WithoutAnAuthorityNothingIsSaidOfTheChain) {
  options_.ca_file = "";
  for (const Finding& finding : CheckSecurityFiles(options_, absl::Now())) {
    EXPECT_EQ(finding.level, Level::kOk) << finding.text;
    EXPECT_EQ(finding.check, "--tls-cert");
  }
}

TEST_F(CertificateChecksTest, WithoutACertificateTheAuthorityIsCheckedAlone) {
  options_.certificate_file = options_.key_file = "";
  const Findings findings = CheckSecurityFiles(options_, absl::Now());
  ASSERT_EQ(findings.size(), 1u) << FormatFindings(findings);
  EXPECT_EQ(findings[0].check, "--tls-ca");
  EXPECT_EQ(findings[0].level, Level::kOk);
}

TEST_F(CertificateChecksTest, FilesThatCannotBeReadAreNamed) {
  SecurityOptions options = options_;
  options.ca_file = "/nowhere/ca.pem";
  EXPECT_EQ(LevelOf(CheckSecurityFiles(options, absl::Now()), "/nowhere/ca.pem"), Level::kFail);
  options = options_;
  options.certificate_file = "/nowhere/alpha.pem";
  EXPECT_EQ(LevelOf(CheckSecurityFiles(options, absl::Now()), "/nowhere/alpha.pem"), Level::kFail);
  options = options_;
  options.key_file = others_.Path("alpha.key");
  EXPECT_EQ(LevelOf(CheckSecurityFiles(options, absl::Now()), "does not belong to"), Level::kFail);
  options = options_;
  options.token_file = "/nowhere/token";
  EXPECT_EQ(LevelOf(CheckSecurityFiles(options, absl::Now()), "/nowhere/token"), Level::kFail);
}

TEST_F(CertificateChecksTest, AServersCertificateIsForTheHostsThatItNames) {
  const std::string pem = Read(certificates_.Path("store.pem"));
  for (const char* host : {"store.lan", "localhost", "127.0.0.1", "::1"}) {
    EXPECT_EQ(CheckHost("x", pem, host).level, Level::kOk) << host;
  }
  for (const char* host : {"other.lan", "10.0.0.5"}) {
    EXPECT_EQ(CheckHost("x", pem, host).level, Level::kFail) << host;
  }
  EXPECT_EQ(CheckHost("x", "no certificate", "store.lan").level, Level::kFail);
}

TEST_F(CertificateChecksTest, InsecureIsSaidAndNothingElseIsLookedAt) {
  options_.insecure = true;
  options_.ca_file = "/nowhere/ca.pem";
  const Findings findings = CheckSecurityFiles(options_, absl::Now());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].level, Level::kWarn);
}

}  // namespace
}  // namespace corbslam::services
