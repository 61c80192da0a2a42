#include "slam/features/pixel_kernels.h"

#include <array>
#include <cstddef>
#include <cstring>

#include "slam/features/fast_kernels.h"

namespace corbslam {
namespace {

using kernels::FastMaxima;
using kernels::FastScores;

// The taps are exp(-i^2 / 8) for i = 0 to 3, scaled to a sum of 256 over all seven.
constexpr uint16_t kTap0 = 56;
constexpr uint16_t kTap1 = 49;
constexpr uint16_t kTap2 = 33;
constexpr uint16_t kTap3 = 18;
static_assert(kTap0 + 2 * (kTap1 + kTap2 + kTap3) == 256);

CORBSLAM_KERNEL uint8_t WeightedMean(uint8_t a3, uint8_t a2, uint8_t a1, uint8_t c, uint8_t b1,
                                     uint8_t b2, uint8_t b3) {
  // The sum is at most 255 * 256 + 128, which fits 16 bits.
  const uint16_t sum = static_cast<uint16_t>(kTap0 * c + kTap1 * (a1 + b1) + kTap2 * (a2 + b2) +
                                             kTap3 * (a3 + b3) + 128);
  return static_cast<uint8_t>(sum >> 8);
}

CORBSLAM_KERNEL void BlurVertical(const uint8_t* const rows[7], int width,
                                  uint8_t* __restrict out) {
  const uint8_t* __restrict const r0 = rows[0];
  const uint8_t* __restrict const r1 = rows[1];
  const uint8_t* __restrict const r2 = rows[2];
  const uint8_t* __restrict const r3 = rows[3];
  const uint8_t* __restrict const r4 = rows[4];
  const uint8_t* __restrict const r5 = rows[5];
  const uint8_t* __restrict const r6 = rows[6];
  for (int x = 0; x < width; ++x) {
    out[x] = WeightedMean(r0[x], r1[x], r2[x], r3[x], r4[x], r5[x], r6[x]);
  }
}

CORBSLAM_KERNEL void BlurHorizontal(const uint8_t* __restrict row, int width,
                                    uint8_t* __restrict out) {
  for (int x = 0; x < width; ++x) {
    out[x] = WeightedMean(row[x - 3], row[x - 2], row[x - 1], row[x], row[x + 1], row[x + 2],
                          row[x + 3]);
  }
}

constexpr int kDiscRows = 2 * kMomentRadius_px + 1;
constexpr int kDiscStride = 32;
using DiscMask = std::array<std::array<int16_t, kDiscStride>, kDiscRows>;

constexpr DiscMask MakeDiscMask() {
  DiscMask mask = {};
  for (int y = -kMomentRadius_px; y <= kMomentRadius_px; ++y) {
    for (int x = -kMomentRadius_px; x <= kMomentRadius_px; ++x) {
      // (r + 1/2)^2 bounds the rounded disc.
      const bool inside = x * x + y * y <= kMomentRadius_px * (kMomentRadius_px + 1);
      mask[static_cast<size_t>(y + kMomentRadius_px)][static_cast<size_t>(x + kMomentRadius_px)] =
          inside ? int16_t{-1} : int16_t{0};
    }
  }
  return mask;
}
constexpr DiscMask kDiscMask = MakeDiscMask();

CORBSLAM_KERNEL PatchMoments DiscMoments(const uint8_t* centre, int64_t stride) {
  // Each column's sum of grey is at most 31 * 255, and its sum of y * grey at most 120 * 255 either
  // way.
  int16_t sums[kDiscStride] = {};
  int16_t weighted[kDiscStride] = {};
  const uint8_t* row = centre - kMomentRadius_px * stride - kMomentRadius_px;
  for (int y = -kMomentRadius_px; y <= kMomentRadius_px; ++y, row += stride) {
    const auto& mask = kDiscMask[static_cast<size_t>(y + kMomentRadius_px)];
    for (int i = 0; i < kDiscStride; ++i) {
      const int16_t grey = static_cast<int16_t>(row[i] & mask[static_cast<size_t>(i)]);
      sums[i] = static_cast<int16_t>(sums[i] + grey);
      weighted[i] = static_cast<int16_t>(weighted[i] + y * grey);
    }
  }
  PatchMoments moments;
  for (int i = 0; i < kDiscStride; ++i) {
    moments.m10 += (i - kMomentRadius_px) * sums[i];
    moments.m01 += weighted[i];
  }
  return moments;
}

// Rounds to the nearest. There are no halves, since the divisor is odd.
CORBSLAM_KERNEL int MeanOfPatch(int sum) {
  constexpr int kArea = kGreySide_px * kGreySide_px;
  return sum >= 0 ? (sum + kArea / 2) / kArea : -((kArea / 2 - sum) / kArea);
}

// Compilers leave loops of so fixed a length in scalar code.
using GreyRow [[gnu::vector_size(kGreyStride * sizeof(int16_t))]] = int16_t;

// Computes the strip's part at a shift, minus the patch. A vector is never returned: without AVX
// that has no calling convention.
CORBSLAM_KERNEL void Subtract(const GreyPatch& patch, const GreyStrip& strip, size_t shift,
                              size_t row, GreyRow& difference) {
  GreyRow of_patch;
  std::memcpy(&difference, &strip[row][shift], sizeof(difference));
  std::memcpy(&of_patch, &patch[row], sizeof(of_patch));
  difference -= of_patch;
}

CORBSLAM_KERNEL int SumOfPatch(const GreyRow& columns) {
  int sum = 0;
  for (int i = 0; i < kGreySide_px; ++i) sum += columns[i];
  return sum;
}

CORBSLAM_KERNEL void StripDifferences(const GreyPatch& patch, const GreyStrip& strip,
                                      std::array<int, kStripShifts>& differences) {
  for (size_t shift = 0; shift < kStripShifts; ++shift) {
    GreyRow sums = {};  // Each is at most 11 * 255 either way.
    GreyRow off;
    for (size_t row = 0; row < kGreySide_px; ++row) {
      Subtract(patch, strip, shift, row, off);
      sums += off;
    }
    const int16_t bias = static_cast<int16_t>(MeanOfPatch(SumOfPatch(sums)));
    GreyRow columns = {};  // Each is at most 11 * 510.
    for (size_t row = 0; row < kGreySide_px; ++row) {
      Subtract(patch, strip, shift, row, off);
      off -= bias;
      columns += off > -off ? off : -off;
    }
    differences[shift] = SumOfPatch(columns);
  }
}

struct Portable {
  static void Scores(const uint8_t* const rows[7], int begin, int end, int threshold,
                     uint8_t* scores) {
    FastScores(rows, begin, end, threshold, scores);
  }
  static void Maxima(const uint8_t* above, const uint8_t* row, const uint8_t* below, int begin,
                     int end, uint8_t* maxima) {
    FastMaxima(above, row, below, begin, end, maxima);
  }
  static void Vertical(const uint8_t* const rows[7], int width, uint8_t* out) {
    BlurVertical(rows, width, out);
  }
  static void Horizontal(const uint8_t* row, int width, uint8_t* out) {
    BlurHorizontal(row, width, out);
  }
  static PatchMoments Moments(const uint8_t* centre, int64_t stride) {
    return DiscMoments(centre, stride);
  }
  static void Strip(const GreyPatch& patch, const GreyStrip& strip,
                    std::array<int, kStripShifts>& differences) {
    StripDifferences(patch, strip, differences);
  }
};

#if defined(__x86_64__)
struct Avx2 {
  [[gnu::target("avx2")]] static void Scores(const uint8_t* const rows[7], int begin, int end,
                                             int threshold, uint8_t* scores) {
    FastScores(rows, begin, end, threshold, scores);
  }
  [[gnu::target("avx2")]] static void Maxima(const uint8_t* above, const uint8_t* row,
                                             const uint8_t* below, int begin, int end,
                                             uint8_t* maxima) {
    FastMaxima(above, row, below, begin, end, maxima);
  }
  [[gnu::target("avx2")]] static void Vertical(const uint8_t* const rows[7], int width,
                                               uint8_t* out) {
    BlurVertical(rows, width, out);
  }
  [[gnu::target("avx2")]] static void Horizontal(const uint8_t* row, int width, uint8_t* out) {
    BlurHorizontal(row, width, out);
  }
  [[gnu::target("avx2")]] static PatchMoments Moments(const uint8_t* centre, int64_t stride) {
    return DiscMoments(centre, stride);
  }
  [[gnu::target("avx2")]] static void Strip(const GreyPatch& patch, const GreyStrip& strip,
                                            std::array<int, kStripShifts>& differences) {
    StripDifferences(patch, strip, differences);
  }
};
#endif

template <typename Target>
constexpr PixelKernels MakeKernels() {
  return {.fast_scores = Target::Scores,
          .fast_maxima = Target::Maxima,
          .blur_vertical = Target::Vertical,
          .blur_horizontal = Target::Horizontal,
          .patch_moments = Target::Moments,
          .strip_differences = Target::Strip};
}

}  // namespace

const PixelKernels& PortablePixelKernels() {
  static constexpr PixelKernels kKernels = MakeKernels<Portable>();
  return kKernels;
}

const PixelKernels* Avx2PixelKernels() {
#if defined(__x86_64__)
  static constexpr PixelKernels kKernels = MakeKernels<Avx2>();
  static const bool kSupported = __builtin_cpu_supports("avx2") != 0;
  return kSupported ? &kKernels : nullptr;
#else
  return nullptr;
#endif
}

const PixelKernels& BestPixelKernels() {
  const PixelKernels* const avx2 = Avx2PixelKernels();
  return avx2 != nullptr ? *avx2 : PortablePixelKernels();
}

}  // namespace corbslam
