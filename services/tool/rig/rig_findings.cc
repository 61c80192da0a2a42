#include "services/tool/rig/rig_findings.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace corbslam::services {

using client_agent::FindingLevel;
using client_agent::SourceFinding;
using client_agent::SourceFindings;

namespace {

// Means of right rigs: at most 0.22 px (EuRoC), 0.52 px (KITTI), 0.05 px (fisheyes of KITTI's
// pictures). Medians lie on whole pixels of a level and say less.
constexpr double kMostRegionRows_px = 1;
// The tracker looks two pixels up and down: there it finds no depth, or a wrong one.
constexpr double kHopelessRegionRows_px = 2;
// So few of a whole sample are chance.
constexpr size_t kFewestMatches = 15;

std::string NameOf(size_t region) {
  constexpr const char* kNames[] = {"top left", "top",         "top right", "left",        "middle",
                                    "right",    "bottom left", "bottom",    "bottom right"};
  static_assert(std::size(kNames) == PairRegions::kRows * PairRegions::kColumns);
  return kNames[region];
}

constexpr absl::string_view kRowsApart = "pair-rows-apart";

bool HasRowsApart(const SourceFindings& found) {
  return std::any_of(found.begin(), found.end(),
                     [](const SourceFinding& finding) { return finding.code == kRowsApart; });
}

bool HasOtherOfPair(const SourceFindings& found) {
  return std::any_of(found.begin(), found.end(), [](const SourceFinding& finding) {
    return absl::StartsWith(finding.code, "pair-") && finding.code != kRowsApart;
  });
}

bool HasError(const SourceFindings& found) {
  return std::any_of(found.begin(), found.end(), [](const SourceFinding& finding) {
    return finding.level == FindingLevel::kError;
  });
}

SourceFinding TellNoPair(const PairRegions& measured) {
  return {FindingLevel::kError, "pair-not-judged",
          absl::StrCat("no pair could be judged: ", measured.all.matches, " matches of ",
                       measured.pairs,
                       " pairs. Give pictures with texture, lit and in focus, of a scene that both "
                       "cameras see, and no mask or rig that leaves all of it out")};
}

}  // namespace

size_t JudgedRegions(const PairRegions& measured) {
  return static_cast<size_t>(
      std::count_if(measured.regions.begin(), measured.regions.end(),
                    [](const RegionRows& region) { return region.matches >= kRegionMatches; }));
}

SourceFindings FindingsOfRegions(const PairRegions& measured, const SourceFindings& found) {
  if (measured.pairs == 0 || measured.all.matches < kFewestMatches) {
    if (HasError(found)) return {};
    return {TellNoPair(measured)};
  }
  if (HasOtherOfPair(found)) return {};
  // What all rows have in common is said already.
  const double common_px = HasRowsApart(found) ? measured.all.row_offset_px : 0;
  std::string where;
  double most_px = 0;
  for (size_t i = 0; i < measured.regions.size(); ++i) {
    const RegionRows& region = measured.regions[i];
    const double apart_px = std::abs(region.row_offset_px - common_px);
    if (region.matches < kRegionMatches || apart_px <= kMostRegionRows_px) continue;
    absl::StrAppendFormat(&where, "%s%s %+.2f px", where.empty() ? "" : ", ", NameOf(i),
                          region.row_offset_px);
    most_px = std::max(most_px, apart_px);
  }
  if (where.empty()) return {};
  return {{most_px > kHopelessRegionRows_px ? FindingLevel::kError : FindingLevel::kWarning,
           "lens-rows-apart",
           absl::StrFormat("rows are apart in parts of the picture and not alike in all: %s "
                           "(right picture lower: +; a right rig has at most %.0f px). Lens, focal "
                           "length or how the cameras are turned is not that of these cameras: "
                           "check lens, lens_numbers, focal_px and right_from_left, or calibrate "
                           "again with the board in the corners, too",
                           where, kMostRegionRows_px)}};
}

}  // namespace corbslam::services
