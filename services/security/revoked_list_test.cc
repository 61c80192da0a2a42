#include "services/security/revoked_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

Identity Named(const std::string& grant, const std::string& token_id = "") {
  return {{*ParseGrant(grant)}, token_id};
}

TEST(RevokedListTest, NamesTokensAndIdentities) {
  const auto list = RevokedList::Parse(
      "# of 2026\n  0123456789abcdef \r\nmissions/lab/agents/alpha # "
      "sold\n\nmissions/old/agents/-\n");
  ASSERT_TRUE(list.ok()) << list.status();
  EXPECT_FALSE(list->Check(Named("missions/lab/agents/bravo", "0123456789abcdef")).ok());
  EXPECT_TRUE(list->Check(Named("missions/lab/agents/bravo", "0123456789abcde0")).ok());
  EXPECT_FALSE(list->Check(Named("missions/lab/agents/alpha")).ok());
  EXPECT_TRUE(list->Check(Named("missions/lab/viewers/alpha")).ok());
  EXPECT_FALSE(list->Check(Named("missions/old/agents/zoe")).ok());
  EXPECT_TRUE(list->Check(Named("missions/-/agents/-")).ok());
  const Identity both = {
      {*ParseGrant("missions/lab/agents/bravo"), *ParseGrant("missions/lab/agents/alpha")}};
  EXPECT_EQ(list->Check(both).code(), absl::StatusCode::kUnauthenticated);
  EXPECT_TRUE(RevokedList::Parse("")->Check(both).ok());
}

TEST(RevokedListTest, OneBadLineIsOneTooMany) {
  for (const char* line : {"missions/lab/robots/alpha", "two words", "missions/lab/agents/a/b"}) {
    const absl::Status status = RevokedList::Parse(std::string("fine\n\n") + line + "\n").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_THAT(std::string(status.message()), HasSubstr("line 3: ")) << line;
  }
}

}  // namespace
}  // namespace corbslam::services
