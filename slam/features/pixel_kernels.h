// The inner loops of feature extraction over rows of 8-bit pixels. Each exists in a portable build
// and, on x86, in one for AVX2, compiled from the same integer arithmetic: the results are equal
// to the bit. Internal to slam/features and slam/sensor.
#ifndef CORBSLAM_SLAM_FEATURES_PIXEL_KERNELS_H_
#define CORBSLAM_SLAM_FEATURES_PIXEL_KERNELS_H_

#include <array>
#include <cstdint>

namespace corbslam {

struct PatchMoments {
  int m10 = 0;  // Sum of x * grey.
  int m01 = 0;  // Sum of y * grey.
};

inline constexpr int kMomentRadius_px = 15;

// A square of kGreySide_px, and one as high with kStripShifts - 1 columns more; both filled up on
// the right, to lengths that suit vectors. What is there does not count.
inline constexpr int kGreySide_px = 11;
inline constexpr int kStripShifts = 11;
inline constexpr int kGreyStride = 16;
inline constexpr int kStripStride = 32;
using GreyPatch = std::array<std::array<int16_t, kGreyStride>, kGreySide_px>;
using GreyStrip = std::array<std::array<int16_t, kStripStride>, kGreySide_px>;

struct PixelKernels {
  // Computes FAST-9 scores of columns [begin, end) of the row rows[3]; rows[0..6] are the seven
  // rows around it. Scores of at most `threshold` become 0. It reads pixels [begin - 3, end + 3).
  void (*fast_scores)(const uint8_t* const rows[7], int begin, int end, int threshold,
                      uint8_t* scores);

  // Sets maxima[x] to row[x] where that is larger than its neighbours (equal ones before it in
  // reading order must be smaller, those after it may be equal), and to 0 elsewhere, for x in
  // [begin, end).
  void (*fast_maxima)(const uint8_t* above, const uint8_t* row, const uint8_t* below, int begin,
                      int end, uint8_t* maxima);

  // Compute the weighted mean of seven rows, or of seven neighbours in a row (x - 3 to x + 3), by
  // the Gaussian of sigma 2, for x in [0, width).
  void (*blur_vertical)(const uint8_t* const rows[7], int width, uint8_t* out);
  void (*blur_horizontal)(const uint8_t* row, int width, uint8_t* out);

  // Returns the first moments of the disc of radius 15 around `centre`. It reads a square of 32 x
  // 31 pixels from (-15, -15) to (16, 15).
  PatchMoments (*patch_moments)(const uint8_t* centre, int64_t stride);

  // Computes, for each whole shift, how far the patch is from the strip's part of its size there:
  // the sum of absolute differences of grey values, from which the mean difference of the two (to a
  // whole grey value) is taken off.
  void (*strip_differences)(const GreyPatch& patch, const GreyStrip& strip,
                            std::array<int, kStripShifts>& differences);
};

const PixelKernels& PortablePixelKernels();

// Returns null where the processor or the architecture has no AVX2.
const PixelKernels* Avx2PixelKernels();

// Returns the fastest kernels that this machine can run.
const PixelKernels& BestPixelKernels();

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_PIXEL_KERNELS_H_
