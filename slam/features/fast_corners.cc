#include "slam/features/fast_corners.h"

#include <algorithm>
#include <cstddef>

#include "slam/features/pixel_kernels.h"

namespace corbslam {
namespace {

constexpr int kCircleRadius_px = 3;

// Cells of about the wanted side that tile the part of an axis inside the margins.
struct CellAxis {
  int begin;
  int length;
  int cells;

  CellAxis(int size, int margin, int cell)
      : begin(margin), length(size - 2 * margin), cells(std::max(1, length / cell)) {}
  int CellOf(int position) const { return (position - begin) * cells / length; }
};

// Appends the columns of `row` that are not 0; most words of eight pixels are.
template <typename Append>
void ForEachNonZero(const uint8_t* row, int begin, int end, Append append) {
  for (int x = begin; x < end;) {
    if (x + 8 <= end && std::all_of(row + x, row + x + 8, [](uint8_t v) { return v == 0; })) {
      x += 8;
      continue;
    }
    const int stop = std::min(x + 8, end);
    for (; x < stop; ++x) {
      if (row[x] != 0) append(x, row[x]);
    }
  }
}

}  // namespace

void FastDetector::ComputeScores(const cv::Mat& image, const FastOptions& options) {
  const PixelKernels& kernels = BestPixelKernels();
  const size_t stride = static_cast<size_t>(image.cols);
  // Rows and columns outside the margin (less the one that suppression looks at) stay 0.
  scores_.assign(stride * static_cast<size_t>(image.rows), 0);
  const int border = options.margin_px - 1;
  for (int y = border; y < image.rows - border; ++y) {
    const uint8_t* rows[7];
    for (int i = 0; i < 7; ++i) rows[i] = image.ptr<uint8_t>(y + i - kCircleRadius_px);
    kernels.fast_scores(rows, border, image.cols - border, options.min_threshold,
                        &scores_[static_cast<size_t>(y) * stride]);
  }
}

void FastDetector::CollectMaxima(const cv::Mat& image, const FastOptions& options,
                                 std::vector<Corner>& corners) {
  const PixelKernels& kernels = BestPixelKernels();
  const size_t stride = static_cast<size_t>(image.cols);
  const int margin = options.margin_px;
  maxima_.resize(stride);
  for (int y = margin; y < image.rows - margin; ++y) {
    const uint8_t* const row = &scores_[static_cast<size_t>(y) * stride];
    kernels.fast_maxima(row - stride, row, row + stride, margin, image.cols - margin,
                        maxima_.data());
    ForEachNonZero(maxima_.data(), margin, image.cols - margin, [&](int x, uint8_t score) {
      corners.push_back({static_cast<int16_t>(x), static_cast<int16_t>(y), score});
    });
  }
}

void FastDetector::Detect(const cv::Mat& image, const FastOptions& options,
                          std::vector<Corner>& corners) {
  corners.clear();
  if (image.cols <= 2 * options.margin_px || image.rows <= 2 * options.margin_px) return;
  ComputeScores(image, options);
  CollectMaxima(image, options, corners);

  const CellAxis columns(image.cols, options.margin_px, options.cell_px);
  const CellAxis rows(image.rows, options.margin_px, options.cell_px);
  const auto cell_of = [&](const Corner& corner) {
    return static_cast<size_t>(rows.CellOf(corner.y_px) * columns.cells +
                               columns.CellOf(corner.x_px));
  };
  cell_has_strong_.assign(static_cast<size_t>(columns.cells * rows.cells), 0);
  for (const Corner& corner : corners) {
    if (corner.score > options.threshold) cell_has_strong_[cell_of(corner)] = 1;
  }
  std::erase_if(corners, [&](const Corner& corner) {
    return corner.score <= options.threshold && cell_has_strong_[cell_of(corner)] != 0;
  });
}

}  // namespace corbslam
