#include "services/security/token.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "services/security/testing/token_keys.h"

namespace corbslam::services {
namespace {

using test_data::MakeTokenKeys;
using test_data::TokenKeys;
using ::testing::HasSubstr;

const absl::Time kNow = absl::FromUnixSeconds(1'800'000'000);

class TokenTest : public ::testing::Test {
 protected:
  static TokenVerifier Verifier(const std::string& pem) {
    absl::StatusOr<TokenVerifier> verifier = TokenVerifier::FromPem(pem);
    EXPECT_TRUE(verifier.ok()) << verifier.status();
    return *std::move(verifier);
  }
  std::string Sign(const std::vector<Grant>& grants = {{Role::kAgent, "lab", "alpha"}}) {
    const auto token = SignToken({grants, kNow + absl::Hours(1)}, keys_.private_pem);
    EXPECT_TRUE(token.ok()) << token.status();
    return token.value_or("");
  }
  void ExpectRefused(const std::string& token, const std::string& why) {
    const auto identity = Verifier(keys_.public_pem).Verify(token, kNow);
    EXPECT_EQ(identity.status().code(), absl::StatusCode::kUnauthenticated) << token;
    EXPECT_THAT(std::string(identity.status().message()), HasSubstr(why)) << token;
  }

  const TokenKeys keys_ = MakeTokenKeys();
};

TEST_F(TokenTest, GrantsWhatWasSigned) {
  const std::vector<Grant> grants = {{Role::kAgent, "lab", "alpha"},
                                     {Role::kOperator, "-", "olga"}};
  const auto identity = Verifier(keys_.public_pem).Verify(Sign(grants), kNow);
  ASSERT_TRUE(identity.ok()) << identity.status();
  EXPECT_EQ(identity->grants, grants);
}

TEST_F(TokenTest, ExpiresToTheSecond) {
  const TokenVerifier verifier = Verifier(keys_.public_pem);
  const std::string token = Sign();
  EXPECT_TRUE(verifier.Verify(token, kNow + absl::Minutes(59)).ok());
  const absl::Status late = verifier.Verify(token, kNow + absl::Hours(1)).status();
  EXPECT_EQ(late.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(std::string(late.message()), HasSubstr("missions/lab/agents/alpha expired at"));
}

TEST_F(TokenTest, OneChangedCharacterIsOneTooMany) {
  const std::string token = Sign();
  for (size_t i = 0; i < token.size(); ++i) {
    // The last character holds bits that mean nothing; all others are signed or the signature.
    if (i + 1 == token.size()) continue;
    std::string changed = token;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    EXPECT_FALSE(Verifier(keys_.public_pem).Verify(changed, kNow).ok()) << i;
  }
}

TEST_F(TokenTest, RefusesWhatIsNoToken) {
  ExpectRefused("", "is no token");
  ExpectRefused("corbslam1.", "is no token");
  ExpectRefused("corbslam1..", "is not signed");
  ExpectRefused("corbslam1.e30", "is no token");
  ExpectRefused("corbslam1.!!.!!", "is no token");
  ExpectRefused(absl::StrCat("corbslam2", Sign().substr(9)), "is no token");
  ExpectRefused(std::string(10'000, 'A'), "is too long");
}

TEST_F(TokenTest, RefusesAnotherKeysToken) {
  const auto token = SignToken({{{Role::kOperator, "-", "eve"}}, kNow + absl::Hours(1)},
                               MakeTokenKeys().private_pem);
  ASSERT_TRUE(token.ok()) << token.status();
  ExpectRefused(*token, "is not signed by a key that this server trusts");
}

TEST_F(TokenTest, RefusesTheClaimsOfOneTokenUnderTheSignatureOfAnother) {
  const std::string mine = Sign();
  const std::string forged = absl::StrCat(
      "corbslam1.",
      absl::WebSafeBase64Escape(R"({"expires":1900000000,"grants":["missions/-/operators/eve"]})"),
      mine.substr(mine.rfind('.')));
  ExpectRefused(forged, "is not signed");
}

TEST_F(TokenTest, RefusesATokenThatGrantsNothing) { ExpectRefused(Sign({}), "grants nothing"); }

TEST_F(TokenTest, KeysCanBeChangedOneAfterTheOther) {
  const TokenKeys next = MakeTokenKeys();
  const TokenVerifier both = Verifier(absl::StrCat(next.public_pem, keys_.public_pem));
  EXPECT_TRUE(both.Verify(Sign(), kNow).ok());
}

TEST_F(TokenTest, AKeyThatCannotBeReadIsNotPassedOver) {
  std::string damaged = MakeTokenKeys().public_pem;
  damaged[damaged.find('\n') + 10] = '!';
  const auto verifier = TokenVerifier::FromPem(absl::StrCat(keys_.public_pem, damaged));
  EXPECT_THAT(std::string(verifier.status().message()), HasSubstr("token key 2"));
  // Text that is no key may stand around the keys.
  EXPECT_TRUE(TokenVerifier::FromPem(absl::StrCat("ours:\n", keys_.public_pem, "\n\n")).ok());
}

TEST_F(TokenTest, OnlyEd25519KeysOfTheRightHalfWillDo) {
  const TokenKeys other = MakeTokenKeys("ED448");
  EXPECT_FALSE(TokenVerifier::FromPem(other.public_pem).ok());
  EXPECT_FALSE(TokenVerifier::FromPem(keys_.private_pem).ok());
  EXPECT_FALSE(TokenVerifier::FromPem("").ok());
  const TokenClaims claims = {{{Role::kAgent, "lab", "alpha"}}, kNow};
  EXPECT_EQ(SignToken(claims, keys_.public_pem).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(SignToken(claims, other.private_pem).ok());
}

TEST_F(TokenTest, NobodyIsAskedForAPassphrase) {
  // The headers say, in PEM's form, that a passphrase is needed.
  const auto behind_passphrase = [](const std::string& pem) {
    const size_t first_line = pem.find('\n') + 1;
    return pem.substr(0, first_line) + "Proc-Type: 4,ENCRYPTED\n" +
           "DEK-Info: AES-128-CBC,00112233445566778899AABBCCDDEEFF\n\n" + pem.substr(first_line);
  };
  EXPECT_FALSE(TokenVerifier::FromPem(behind_passphrase(keys_.public_pem)).ok());
  const TokenClaims claims = {{{Role::kAgent, "lab", "alpha"}}, kNow};
  EXPECT_FALSE(SignToken(claims, behind_passphrase(keys_.private_pem)).ok());
}

TEST_F(TokenTest, HasWhatItIsRevokedAndLimitedBy) {
  TokenClaims claims = {{{Role::kAgent, "lab", "alpha"}}, kNow + absl::Hours(1)};
  claims.id = *MakeTokenId();
  claims.issued = kNow;
  claims.audience = "store-1";
  const auto token = SignToken(claims, keys_.private_pem);
  ASSERT_TRUE(token.ok()) << token.status();
  const auto read = Verifier(keys_.public_pem).Read(*token);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->id, claims.id);
  EXPECT_EQ(read->issued, claims.issued);
  EXPECT_EQ(read->audience, "store-1");
  EXPECT_EQ(Verifier(keys_.public_pem).Verify(*token, kNow)->token_id, claims.id);
  EXPECT_NE(*MakeTokenId(), *MakeTokenId());
  claims.id = "two words";
  EXPECT_EQ(SignToken(claims, keys_.private_pem).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(TokenTest, AnOldTokenHasAnIdOfItsOwn) {
  const std::string alpha = Verifier(keys_.public_pem).Read(Sign())->id;
  EXPECT_THAT(alpha, ::testing::MatchesRegex("sha256-[0-9a-f]{16}"));
  EXPECT_EQ(Verifier(keys_.public_pem).Read(Sign())->id, alpha);
  const std::vector<Grant> others = {{Role::kAgent, "lab", "bravo"}};
  EXPECT_NE(Verifier(keys_.public_pem).Read(Sign(others))->id, alpha);
}

TEST_F(TokenTest, IsNotLongerThanMetadataMayBe) {
  const std::vector<Grant> grants(500, {Role::kAgent, "a-mission", "a-robot"});
  EXPECT_EQ(SignToken({grants, kNow}, keys_.private_pem).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam::services
