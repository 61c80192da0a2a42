#include "services/http/web_target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

TEST(WebTargetTest, SplitsAndDecodes) {
  WebRequest request;
  ASSERT_TRUE(ReadTarget("/api/missions/a%20b?x=1&y=a+b%2Bc&&z", request));
  EXPECT_EQ(request.path, "/api/missions/a b");
  EXPECT_THAT(request.query, ElementsAre(Pair("x", "1"), Pair("y", "a b+c"), Pair("z", "")));
}

TEST(WebTargetTest, TakesWhateverOtherFormThereIs) {
  for (const auto& [target, path] : {std::pair("http://host/a?b", "/a"),
                                     {"http://host", "/"},
                                     {"/a://b/c", "/a://b/c"},
                                     {"*", "*"}}) {
    WebRequest request;
    ASSERT_TRUE(ReadTarget(target, request)) << target;
    EXPECT_EQ(request.path, path);
  }
}

TEST(WebTargetTest, RefusesWhatIsNoTarget) {
  for (const char* target : {"", "x", "http://host?a", "/%", "/%4", "/%zz", "/%00", "/?a=%1"}) {
    WebRequest request;
    EXPECT_FALSE(ReadTarget(target, request)) << target;
  }
}

TEST(WebTargetTest, FindsTheTokenAmongProtocols) {
  EXPECT_EQ(TokenOfProtocols("corbslam, token.corbslam1.abc.d-_e"), "corbslam1.abc.d-_e");
  EXPECT_EQ(TokenOfProtocols("corbslam"), "");
  EXPECT_EQ(TokenOfProtocols(""), "");
  EXPECT_TRUE(OffersProtocol("x ,corbslam", "corbslam"));
  EXPECT_FALSE(OffersProtocol("xcorbslam", "corbslam"));
}

TEST(WebTargetTest, KnowsItsOwnPages) {
  EXPECT_TRUE(IsSameOrigin("", "host:8080"));
  EXPECT_TRUE(IsSameOrigin("http://Host:8080", "host:8080"));
  EXPECT_FALSE(IsSameOrigin("http://evil", "host:8080"));
  EXPECT_FALSE(IsSameOrigin("http://host", "host:8080"));
  EXPECT_FALSE(IsSameOrigin("null", "host:8080"));
}

}  // namespace
}  // namespace corbslam::services
