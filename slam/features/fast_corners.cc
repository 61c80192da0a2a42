#include "slam/features/fast_corners.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "slam/features/pixel_kernels.h"

namespace corbslam {
namespace {

constexpr int kCircleRadius_px = 3;

// Cells of about the wanted side tile the part of an axis inside the margins; sets the cell of each
// position there and returns how many there are.
int AssignCells(int size, int margin, int cell, std::vector<int>& cell_of) {
  const int length = size - 2 * margin;
  const int cells = std::max(1, length / cell);
  cell_of.resize(static_cast<size_t>(size));
  for (int i = 0; i < length; ++i) cell_of[static_cast<size_t>(margin + i)] = i * cells / length;
  return cells;
}

// Appends the columns of `row` that are not 0. Most words of eight pixels are.
template <typename Append>
void ForEachNonZero(const uint8_t* row, int begin, int end, Append append) {
  static_assert(std::endian::native == std::endian::little);
  int x = begin;
  for (; x + 8 <= end; x += 8) {
    uint64_t eight = 0;
    std::memcpy(&eight, row + x, 8);
    while (eight != 0) {
      const int bit = std::countr_zero(eight) & ~7;
      append(x + bit / 8, static_cast<uint8_t>(eight >> bit));
      eight &= ~(uint64_t{0xff} << bit);
    }
  }
  for (; x < end; ++x) {
    if (row[x] != 0) append(x, row[x]);
  }
}

}  // namespace

void FastDetector::CollectMaxima(const cv::Mat& image, const FastOptions& options,
                                 std::vector<Corner>& corners) {
  const PixelKernels& kernels = BestPixelKernels();
  const int margin = options.margin_px;
  const int border = margin - 1;  // Suppression looks at one pixel more on each side.
  for (auto& row : scores_) row.resize(static_cast<size_t>(image.cols));
  maxima_.resize(static_cast<size_t>(image.cols));
  const auto scores_of = [this](int y) { return scores_[static_cast<size_t>(y % 3)].data(); };
  for (int y = border; y < image.rows - border; ++y) {
    const uint8_t* rows[7];
    for (int i = 0; i < 7; ++i) rows[i] = image.ptr<uint8_t>(y + i - kCircleRadius_px);
    kernels.fast_scores(rows, border, image.cols - border, options.min_threshold, scores_of(y));
    const int middle = y - 1;
    if (middle < margin) continue;
    kernels.fast_maxima(scores_of(middle - 1), scores_of(middle), scores_of(y), margin,
                        image.cols - margin, maxima_.data());
    ForEachNonZero(maxima_.data(), margin, image.cols - margin, [&](int x, uint8_t score) {
      corners.push_back({static_cast<int16_t>(x), static_cast<int16_t>(middle), score});
    });
  }
}

void FastDetector::DropWeakCorners(const cv::Mat& image, const FastOptions& options,
                                   std::vector<Corner>& corners) {
  const int columns = AssignCells(image.cols, options.margin_px, options.cell_px, cell_of_column_);
  const int rows = AssignCells(image.rows, options.margin_px, options.cell_px, cell_of_row_);
  const auto cell_of = [&](const Corner& corner) {
    return static_cast<size_t>(cell_of_row_[static_cast<size_t>(corner.y_px)] * columns +
                               cell_of_column_[static_cast<size_t>(corner.x_px)]);
  };
  cell_has_strong_.assign(static_cast<size_t>(columns * rows), 0);
  for (const Corner& corner : corners) {
    if (corner.score > options.threshold) cell_has_strong_[cell_of(corner)] = 1;
  }
  std::erase_if(corners, [&](const Corner& corner) {
    return corner.score <= options.threshold && cell_has_strong_[cell_of(corner)] != 0;
  });
}

void FastDetector::Detect(const cv::Mat& image, const FastOptions& options,
                          std::vector<Corner>& corners) {
  corners.clear();
  if (image.cols <= 2 * options.margin_px || image.rows <= 2 * options.margin_px) return;
  CollectMaxima(image, options, corners);
  DropWeakCorners(image, options, corners);
}

}  // namespace corbslam
