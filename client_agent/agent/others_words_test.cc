#include "client_agent/agent/others_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(DescribeOthersTest, NamesTheLocalMapAndByHowMuchItContradicts) {
  const SourceFinding finding = DescribeOthers({LocalMapId{0xabc}, true, 6.25});
  EXPECT_EQ(finding.level, FindingLevel::kWarning);
  EXPECT_EQ(finding.code, "others-contradict");
  EXPECT_THAT(finding.text, HasSubstr(ToString(LocalMapId{0xabc})));
  EXPECT_THAT(finding.text, HasSubstr("6.2 times"));
}

TEST(DescribeOthersTest, SaysThatItFitsAgain) {
  const SourceFinding finding = DescribeOthers({LocalMapId{0xabc}, false, 2});
  EXPECT_EQ(finding.code, "others-fit-again");
  EXPECT_THAT(finding.text, HasSubstr(ToString(LocalMapId{0xabc})));
}

}  // namespace
}  // namespace corbslam::client_agent
