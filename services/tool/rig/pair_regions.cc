#include "services/tool/rig/pair_regions.h"

#include <algorithm>
#include <cmath>

#include "slam/util/median.h"

namespace corbslam::services {

using client_agent::FeatureMatch;
using client_agent::JudgedPair;
using client_agent::PairPreparation;

namespace {

constexpr double kNearMedian_px = 3;
constexpr double kMoved_px = 1;
constexpr double kTail = 0.05;

double RowsApart(const FeatureMatch& match) { return match.in_b.y() - match.in_a.y(); }

double MeanNearMedian(const std::vector<double>& rows_px) {
  const double median_px = Median(rows_px);
  double sum_px = 0;
  size_t count = 0;
  for (const double row_px : rows_px) {
    if (std::abs(row_px - median_px) > kNearMedian_px) continue;
    sum_px += row_px;
    ++count;
  }
  return sum_px / static_cast<double>(count);
}

RegionRows Summarise(const std::vector<double>& rows_px) {
  if (rows_px.empty()) return {};
  std::vector<double> sizes;
  for (const double row_px : rows_px) sizes.push_back(std::abs(row_px));
  return {rows_px.size(), Median(std::move(sizes)), MeanNearMedian(rows_px)};
}

size_t RegionOf(const FeatureMatch& match, const Camera& camera) {
  const auto part = [](double at, int side, size_t parts) {
    const auto which = static_cast<size_t>(std::max(0.0, at / side * static_cast<double>(parts)));
    return std::min(parts - 1, which);
  };
  return part(match.in_a.y(), camera.height_px, PairRegions::kRows) * PairRegions::kColumns +
         part(match.in_a.x(), camera.width_px, PairRegions::kColumns);
}

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

PairRegions MeasureRegions(const PairPreparation& preparation,
                           const std::vector<JudgedPair>& pairs) {
  PairRegions measured;
  std::array<std::vector<double>, PairRegions::kColumns * PairRegions::kRows> rows_px;
  std::vector<double> all_rows_px;
  std::vector<double> disparities_px;
  measured.pairs = pairs.size();
  for (const JudgedPair& pair : pairs) {
    for (const FeatureMatch& match : pair.matches) {
      rows_px[RegionOf(match, preparation.camera())].push_back(RowsApart(match));
      all_rows_px.push_back(RowsApart(match));
      disparities_px.push_back(match.in_a.x() - match.in_b.x());
    }
  }
  for (size_t i = 0; i < rows_px.size(); ++i) measured.regions[i] = Summarise(rows_px[i]);
  measured.all = Summarise(all_rows_px);
  if (disparities_px.empty()) return measured;
  std::sort(disparities_px.begin(), disparities_px.end());
  measured.low_disparity_px = Quantile(disparities_px, kTail);
  measured.high_disparity_px = Quantile(disparities_px, 1 - kTail);
  const auto negative =
      std::count_if(disparities_px.begin(), disparities_px.end(),
                    [](double disparity_px) { return disparity_px < -kMoved_px; });
  measured.negative_share =
      static_cast<double>(negative) / static_cast<double>(disparities_px.size());
  return measured;
}

}  // namespace corbslam::services
