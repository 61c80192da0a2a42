#include "client_agent/agent/contradiction_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(ContradictionTextTest, SayWhichMapByHowMuchAndHowSure) {
  const SourceFinding large = DescribeContradiction({LocalMapId{0xab}, 1.0141, 0.0016});
  EXPECT_EQ(large.level, FindingLevel::kWarning);
  EXPECT_EQ(large.code, "others-distances");
  EXPECT_THAT(large.text, HasSubstr("local map 00000000000000ab of another robot is 1.41 % larger "
                                    "than what this robot's camera measures (standard deviation "
                                    "0.16 %)"));
  EXPECT_THAT(DescribeContradiction({LocalMapId{0xab}, 0.98, 0.001}).text,
              HasSubstr("2.00 % smaller than"));
}

TEST(ContradictionTextTest, SayWhereAMapIsBent) {
  const SourceFinding bent =
      DescribeContradiction({LocalMapId{0xab}, 1, 0, MapBend{4.52, 0.127, 0.0122}});
  EXPECT_EQ(bent.level, FindingLevel::kWarning);
  EXPECT_EQ(bent.code, "others-shape");
  EXPECT_THAT(bent.text, HasSubstr("local map 00000000000000ab of another robot is bent or torn "
                                   "here: over 4.5 m of it this robot's own sight ends 0.13 m "
                                   "beside what that map says, and turned by 0.70 degrees"));
}

}  // namespace
}  // namespace corbslam::client_agent
