#include "slam/exchange/agent_report.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

TEST(DescribeContradictionTest, SaysHowTheOtherMapIs) {
  MapContradiction found{LocalMapId{0xab}, 0.986, 0.0016};
  EXPECT_EQ(Describe(found), "1.40 % smaller than what its camera measures (+-0.16 %)");
  found.scale = 1.02;
  EXPECT_EQ(Describe(found), "2.00 % larger than what its camera measures (+-0.16 %)");
  found.bend = MapBend{4.5, 0.127, 0.0122};
  EXPECT_EQ(Describe(found),
            "bent: over 4.5 m its camera ends 0.13 m beside, turned by 0.70 degrees");
}

}  // namespace
}  // namespace corbslam
