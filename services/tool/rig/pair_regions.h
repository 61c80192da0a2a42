// Measures how well the rows of a rectified pair agree, in each part of its pictures.
#ifndef CORBSLAM_SERVICES_TOOL_RIG_PAIR_REGIONS_H_
#define CORBSLAM_SERVICES_TOOL_RIG_PAIR_REGIONS_H_

#include <array>
#include <vector>

#include "client_agent/source_checks/pair_evidence.h"

namespace corbslam::services {

struct RegionRows {
  size_t matches = 0;
  double row_error_px = 0;  // Median of the size of y_right - y_left.
  // The same with its sign (above 0: the right picture is lower): the mean of those within three
  // pixels of the median, since corners lie on whole pixels.
  double row_offset_px = 0;
};

struct PairRegions {
  static constexpr size_t kColumns = 3;
  static constexpr size_t kRows = 3;
  // By rows, from the top left.
  std::array<RegionRows, kColumns * kRows> regions;
  RegionRows all;
  size_t pairs = 0;
  // Disparities of the matches, pixels: a twentieth is less, and a twentieth more.
  double low_disparity_px = 0;
  double high_disparity_px = 0;
  // Share of the matches that lie farther right in the right picture, where nothing can be.
  double negative_share = 0;
};

// Measures pairs that `preparation` has judged. Pure.
PairRegions MeasureRegions(const client_agent::PairPreparation& preparation,
                           const std::vector<client_agent::JudgedPair>& pairs);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RIG_PAIR_REGIONS_H_
