#include "services/tool/rig/rig_findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using client_agent::FindingLevel;
using client_agent::SourceFindings;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// Rows as a right rig has them: KITTI's are half a pixel apart at the top right.
PairRegions Right() {
  PairRegions measured;
  measured.pairs = 40;
  measured.all = {4500, 0, 0.03};
  for (auto& region : measured.regions) region = {500, 0, 0.1};
  measured.regions[2].row_offset_px = -0.52;
  return measured;
}

TEST(RigFindingsTest, ARightRigHasNone) {
  EXPECT_THAT(FindingsOfRegions(Right(), {}), SizeIs(0));
  EXPECT_EQ(JudgedRegions(Right()), 9u);
}

TEST(RigFindingsTest, NamesTheRegionsInWhichAWrongLensMovesRows) {
  PairRegions measured = Right();
  measured.regions[2].row_offset_px = -3.6;
  measured.regions[6].row_offset_px = 1.29;
  const SourceFindings findings = FindingsOfRegions(measured, {});
  ASSERT_THAT(findings, SizeIs(1));
  EXPECT_EQ(findings[0].code, "lens-rows-apart");
  EXPECT_EQ(findings[0].level, FindingLevel::kError);
  EXPECT_THAT(findings[0].text, HasSubstr("top right -3.60 px, bottom left +1.29 px"));
  EXPECT_THAT(findings[0].text, Not(HasSubstr("middle")));

  measured.regions[2].row_offset_px = -1.99;
  EXPECT_EQ(FindingsOfRegions(measured, {})[0].level, FindingLevel::kWarning);
}

TEST(RigFindingsTest, FewMatchesSayNothingAboutARegion) {
  PairRegions measured = Right();
  measured.regions[0] = {kRegionMatches - 1, 4, 4};
  EXPECT_THAT(FindingsOfRegions(measured, {}), SizeIs(0));
  EXPECT_EQ(JudgedRegions(measured), 8u);
}

TEST(RigFindingsTest, WhatIsWrongEverywhereIsNotSaidAgainByRegion) {
  PairRegions measured = Right();
  for (auto& region : measured.regions) region.row_offset_px = 2.5;
  measured.all.row_offset_px = 2.5;
  const SourceFindings apart = {{FindingLevel::kWarning, "pair-rows-apart", ""}};
  EXPECT_THAT(FindingsOfRegions(measured, apart), SizeIs(0));
  measured.regions[8].row_offset_px = 12;
  ASSERT_THAT(FindingsOfRegions(measured, apart), SizeIs(1));
  EXPECT_THAT(FindingsOfRegions(measured, apart)[0].text, HasSubstr("all: bottom right +12.00 px"));
  EXPECT_THAT(FindingsOfRegions(measured, {{FindingLevel::kWarning, "pair-late", ""}}), SizeIs(0));
}

TEST(RigFindingsTest, WithoutAPairNothingIsUsable) {
  const SourceFindings findings = FindingsOfRegions(PairRegions(), {});
  ASSERT_THAT(findings, SizeIs(1));
  EXPECT_EQ(findings[0].code, "pair-not-judged");
  EXPECT_EQ(findings[0].level, FindingLevel::kError);
  EXPECT_THAT(findings[0].text, HasSubstr("0 matches of 0 pairs"));
}

}  // namespace
}  // namespace corbslam::services
