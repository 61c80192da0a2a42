#include "map_store/view/page_tokens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/testing/name_lists.h"
#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using testing::Agents;
using ::testing::HasSubstr;
using testing::Keyframes;
using testing::List;
using ::testing::SizeIs;
using testing::TwoRobots;

class PageTokensTest : public TwoRobots {
 protected:
  PageTokensTest() {
    StreamBoth();
    Fuse();
  }
  std::vector<std::pair<std::string, List>> AllLists() const {
    return testing::AllLists(store_, a_.local_map(), b_.local_map());
  }
};

TEST_F(PageTokensTest, TokensAreOfOneListOnly) {
  const auto lists = AllLists();
  for (const auto& [from, giving] : lists) {
    const auto page = giving({1, ""});
    ASSERT_TRUE(page.ok()) << from;
    if (page->next_page_token.empty()) continue;
    for (const auto& [to, taking] : lists) {
      const auto taken = taking({1, page->next_page_token});
      EXPECT_EQ(taken.ok(), from == to) << "from " << from << " to " << to;
      if (taken.ok()) continue;
      EXPECT_TRUE(absl::IsInvalidArgument(taken.status())) << taken.status();
      EXPECT_THAT(std::string(taken.status().message()), HasSubstr("next_page_token of the page"));
    }
  }
}

TEST_F(PageTokensTest, AnotherMissionsTokenIsRefused) {
  const auto page = Agents(store_)({1, ""});
  ASSERT_NE(page->next_page_token, "");
  SessionRequest request;
  request.mission = "n";
  request.agent = "a";
  ASSERT_TRUE(store_.OpenSession(request).ok());
  const auto taken = Agents(store_, "n")({1, page->next_page_token});
  EXPECT_TRUE(absl::IsInvalidArgument(taken.status())) << taken.status();
}

TEST_F(PageTokensTest, WhatIsNoTokenIsRefusedByEveryList) {
  const std::string good = Keyframes(store_, {})({1, ""})->next_page_token;
  std::string changed = good;
  changed.back() = changed.back() == 'A' ? 'B' : 'A';
  for (const auto& [what, list] : AllLists()) {
    for (const std::string& token :
         {std::string("1"), std::string("0"), std::string("x"), std::string("missions/m"),
          std::string(1, '\0'), std::string(1 << 20, 'A'), std::string("AAAA"), good + "=",
          good + "A", " " + good, good.substr(0, good.size() - 1), changed,
          std::string("\xff\xfe")}) {
      const auto taken = list({1, token});
      EXPECT_TRUE(absl::IsInvalidArgument(taken.status())) << what << ": " << token.substr(0, 40);
    }
  }
}

// Whoever reads our code can make tokens up; their keys may still be nonsense.
TEST_F(PageTokensTest, KeysThatAreMadeUpAreRefusedOrEmpty) {
  const auto token = [](const std::string& list, const std::string& key) {
    return map_store::MakePageToken({.list = list, .after = "", .size = 1}, key);
  };
  for (const char* key : {"x", "-1", "0", "/", "1/", "0/x", "1/2/3/4", "99999999999999999999"}) {
    EXPECT_FALSE(store_.ListKeyframes("m", {}, {1, token("m/keyframes/", key)}).ok()) << key;
  }
  for (const char* key : {"x", "-1", "99999999999999999999", "1/2"}) {
    // One of them is a place that another book gave out.
    EXPECT_FALSE(store_.ListLocalMaps("m", {1, token("m/localMaps", key)}).ok()) << key;
    EXPECT_FALSE(store_.ListOverlaps("m", {}, {1, token("m/overlaps//", key)}).ok()) << key;
  }
  const std::string last = absl::StrCat(~uint64_t{0});
  // Of a local map that is not there, or of one that was read anew after others had gone.
  EXPECT_THAT(store_.ListKeyframes("m", {}, {1, token("m/keyframes/", last + "/0/1")})->items,
              SizeIs(0));
  EXPECT_TRUE(
      absl::IsAborted(store_.ListKeyframes("m", {}, {1, token("m/keyframes/", "0/1/1")}).status()));
  EXPECT_FALSE(store_.ListKeyframes("m", {}, {1, token("m/keyframes/", "0/0/" + last)}).ok());
  EXPECT_THAT(store_.ListOverlaps("m", {}, {1, token("m/overlaps//", last)})->items, SizeIs(0));
  EXPECT_THAT(store_.ListLocalMaps("m", {1, token("m/localMaps", last + "/0")})->items, SizeIs(0));
}

}  // namespace
}  // namespace corbslam::map_store
