#include "services/security/identity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(GrantTest, ReadsWhatItWrites) {
  for (const char* text :
       {"missions/lab/agents/alpha", "missions/lab/agents/-", "missions/-/viewers/eve",
        "missions/lab/operators/olga", "stores/main", "workers/one"}) {
    const absl::StatusOr<Grant> grant = ParseGrant(text);
    ASSERT_TRUE(grant.ok()) << grant.status();
    EXPECT_EQ(FormatGrant(*grant), text);
  }
  EXPECT_EQ(*ParseGrant("missions/lab/operators/olga"), (Grant{Role::kOperator, "lab", "olga"}));
}

TEST(GrantTest, RefusesTheRest) {
  for (const std::string text :
       {"", "/", "missions/lab", "missions/lab/agents", "missions/lab/agents/",
        "missions/lab/agents/alpha/", "missions//agents/alpha", "missions/lab/pilots/alpha",
        "missions/lab/stores/main", "agents/alpha", "stores/-", "missions/lab/viewers/-",
        "missions/lab/agents/a b", "Missions/lab/agents/alpha", "missions/--/agents/alpha"}) {
    EXPECT_EQ(ParseGrant(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
  const std::string with_zero("missions/lab\0/agents/alpha", 26);
  EXPECT_FALSE(ParseGrant(with_zero).ok());
}

TEST(IdentityTest, IsWhatTheCertificatesUrisSay) {
  const auto identity =
      IdentityFromUris({"https://example.org/x", "corbslam:missions/lab/agents/alpha",
                        "corbslam:missions/field/viewers/alpha"});
  ASSERT_TRUE(identity.ok()) << identity.status();
  EXPECT_EQ(Describe(*identity), "missions/lab/agents/alpha missions/field/viewers/alpha");
}

TEST(IdentityTest, ACertificateOfAnotherKindIsNobody) {
  for (const std::vector<std::string>& uris :
       {std::vector<std::string>{}, {"spiffe://example.org/missions/lab/operators/olga"}}) {
    EXPECT_EQ(IdentityFromUris(uris).status().code(), absl::StatusCode::kUnauthenticated);
  }
}

// The part of the certificate that can be read does not count either.
TEST(IdentityTest, ACertificateThatCannotBeReadIsNobody) {
  const auto identity =
      IdentityFromUris({"corbslam:missions/lab/agents/alpha", "corbslam:missions/lab/pilots/p"});
  EXPECT_EQ(identity.status().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(std::string(identity.status().message()), HasSubstr("missions/lab/pilots/p"));
}

TEST(IdentityTest, AMessageNamesTheFirstOfMany) {
  Identity identity;
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    identity.grants.push_back({Role::kAgent, "m", name});
  }
  EXPECT_EQ(Describe(identity),
            "missions/m/agents/a missions/m/agents/b missions/m/agents/c missions/m/agents/d ...");
}

}  // namespace
}  // namespace corbslam::services
