#include "client_agent/agent/others_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(OthersWordsTest, SayWhichMapByHowMuchAndHowSure) {
  const SourceFinding large = DescribeContradiction({LocalMapId{0xab}, 1.0141, 0.0016});
  EXPECT_EQ(large.level, FindingLevel::kWarning);
  EXPECT_EQ(large.code, "others-distances");
  EXPECT_THAT(large.text, HasSubstr("local map 00000000000000ab of another robot is 1.41 % larger "
                                    "than what this robot's camera measures (standard deviation "
                                    "0.16 %)"));
  EXPECT_THAT(DescribeContradiction({LocalMapId{0xab}, 0.98, 0.001}).text,
              HasSubstr("2.00 % smaller than"));
}

}  // namespace
}  // namespace corbslam::client_agent
