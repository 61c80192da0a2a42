#include "slam/features/gaussian_blur.h"

#include <cstdint>
#include <vector>

#include "slam/features/pixel_kernels.h"

namespace corbslam {
namespace {

constexpr int kRadius_px = 3;

// Mirrors an index about the first and the last pixel.
int Mirrored(int i, int size) {
  if (i < 0) return -i;
  return i < size ? i : 2 * (size - 1) - i;
}

}  // namespace

void BlurGaussian7x7(const cv::Mat& image, cv::Mat& blurred) {
  const PixelKernels& kernels = BestPixelKernels();
  const int width = image.cols;
  blurred.create(image.rows, width, CV_8UC1);
  std::vector<uint8_t> buffer(static_cast<size_t>(width + 2 * kRadius_px));
  uint8_t* const row = buffer.data() + kRadius_px;
  for (int y = 0; y < image.rows; ++y) {
    const uint8_t* rows[7];
    for (int i = 0; i < 7; ++i) {
      rows[i] = image.ptr<uint8_t>(Mirrored(y + i - kRadius_px, image.rows));
    }
    kernels.blur_vertical(rows, width, row);
    for (int i = 1; i <= kRadius_px; ++i) {
      row[-i] = row[i];
      row[width - 1 + i] = row[width - 1 - i];
    }
    kernels.blur_horizontal(row, width, blurred.ptr<uint8_t>(y));
  }
}

}  // namespace corbslam
