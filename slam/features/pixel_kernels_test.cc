#include "slam/features/pixel_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace corbslam {
namespace {

constexpr int kWidth_px = 203;  // It is not a multiple of any vector's length.
constexpr int kHeight_px = 40;

// Makes flat areas, edges and noise, which have scores of every size.
std::vector<uint8_t> RandomPixels(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint8_t> pixels(kWidth_px * kHeight_px);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const uint8_t block = (i / 9) % 2 == 0 ? 40 : 200;
    pixels[i] = static_cast<uint8_t>(block + random() % ((i / 50) % 4 * 16 + 1));
    if (random() % 16 == 0) pixels[i] = static_cast<uint8_t>(random());
  }
  return pixels;
}

// Makes nearly flat pixels with a few small squares: most blocks of a row have no corner.
std::vector<uint8_t> CalmPixels(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint8_t> pixels(kWidth_px * kHeight_px);
  for (uint8_t& pixel : pixels) pixel = static_cast<uint8_t>(100 + random() % 5);
  for (int i = 0; i < 12; ++i) {
    const size_t first = random() % (pixels.size() - 4 * kWidth_px);
    const auto grey = static_cast<uint8_t>(random());
    for (size_t y = 0; y < 4; ++y) std::fill_n(&pixels[first + y * kWidth_px], 4, grey);
  }
  return pixels;
}

// Computes the score by its definition, trying every arc.
int FastScoreByDefinition(const std::vector<uint8_t>& pixels, int x, int y) {
  constexpr int kDx[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int kDy[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  const int centre = pixels[static_cast<size_t>(y * kWidth_px + x)];
  int best = 0;
  for (int start = 0; start < 16; ++start) {
    int brighter = 255, darker = 255;
    for (int i = start; i < start + 9; ++i) {
      const int p = pixels[static_cast<size_t>((y + kDy[i % 16]) * kWidth_px + x + kDx[i % 16])];
      brighter = std::min(brighter, p - centre);
      darker = std::min(darker, centre - p);
    }
    best = std::max({best, brighter, darker});
  }
  return best;
}

struct Outputs {
  std::vector<uint8_t> scores, maxima, vertical, horizontal;
  std::vector<int> sums;
};

Outputs RunAll(const PixelKernels& kernels, const std::vector<uint8_t>& pixels) {
  Outputs out;
  for (auto* plane : {&out.scores, &out.maxima, &out.vertical, &out.horizontal}) {
    plane->assign(pixels.size(), 0);
  }
  const auto row = [](auto& plane, int y) { return plane.data() + y * kWidth_px; };
  for (int y = 3; y < kHeight_px - 3; ++y) {
    const uint8_t* rows[7];
    for (int i = 0; i < 7; ++i) rows[i] = row(pixels, y + i - 3);
    kernels.fast_scores(rows, 3, kWidth_px - 3, 7, row(out.scores, y));
    kernels.blur_vertical(rows, kWidth_px, row(out.vertical, y));
    kernels.blur_horizontal(row(pixels, y) + 3, kWidth_px - 6, row(out.horizontal, y));
  }
  for (int y = 4; y < kHeight_px - 4; ++y) {
    kernels.fast_maxima(row(out.scores, y - 1), row(out.scores, y), row(out.scores, y + 1), 4,
                        kWidth_px - 4, row(out.maxima, y));
  }
  for (int x = 16; x < kWidth_px - 16; ++x) {
    const PatchMoments moments = kernels.patch_moments(row(pixels, 18) + x, kWidth_px);
    out.sums.insert(out.sums.end(), {moments.m10, moments.m01});
  }
  return out;
}

TEST(PixelKernelsTest, EveryInstructionSetGivesTheSameBits) {
  const PixelKernels* const avx2 = Avx2PixelKernels();
  if (avx2 == nullptr) GTEST_SKIP() << "no AVX2 here";
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<uint8_t> pixels = RandomPixels(seed);
    const Outputs portable = RunAll(PortablePixelKernels(), pixels);
    const Outputs wide = RunAll(*avx2, pixels);
    EXPECT_EQ(portable.scores, wide.scores);
    EXPECT_EQ(portable.maxima, wide.maxima);
    EXPECT_EQ(portable.vertical, wide.vertical);
    EXPECT_EQ(portable.horizontal, wide.horizontal);
    EXPECT_EQ(portable.sums, wide.sums);
  }
}

TEST(PixelKernelsTest, FastScoresFollowTheDefinition) {
  for (const auto& pixels : {RandomPixels(7), CalmPixels(1), CalmPixels(2), CalmPixels(3)}) {
    const Outputs out = RunAll(BestPixelKernels(), pixels);
    int corners = 0;
    for (int y = 3; y < kHeight_px - 3; ++y) {
      for (int x = 3; x < kWidth_px - 3; ++x) {
        const int score = FastScoreByDefinition(pixels, x, y);
        ASSERT_EQ(out.scores[static_cast<size_t>(y * kWidth_px + x)], score > 7 ? score : 0);
        corners += score > 7;
      }
    }
    EXPECT_GT(corners, 20);
  }
}

// Weighs seven pixels that lie `step` apart around `centre` by the taps of a Gaussian of sigma 2.
int BlurByDefinition(const std::vector<uint8_t>& pixels, int centre, int step) {
  constexpr int kTaps[4] = {56, 49, 33, 18};
  int sum = 128;
  for (int i = -3; i <= 3; ++i) {
    sum += kTaps[std::abs(i)] * pixels[static_cast<size_t>(centre + i * step)];
  }
  return sum / 256;
}

TEST(PixelKernelsTest, BlursFollowTheDefinition) {
  const std::vector<uint8_t> pixels = RandomPixels(9);
  const Outputs out = RunAll(BestPixelKernels(), pixels);
  for (int y = 3; y < kHeight_px - 3; ++y) {
    for (int x = 0; x < kWidth_px; ++x) {
      const int at = y * kWidth_px + x;
      ASSERT_EQ(out.vertical[static_cast<size_t>(at)], BlurByDefinition(pixels, at, kWidth_px));
      if (x >= kWidth_px - 6) continue;
      // RunAll writes a row's first blurred pixel, that of column 3, to column 0.
      ASSERT_EQ(out.horizontal[static_cast<size_t>(at)], BlurByDefinition(pixels, at + 3, 1));
    }
  }
}

TEST(PixelKernelsTest, MomentsFollowTheDefinition) {
  const std::vector<uint8_t> pixels = RandomPixels(3);
  int m10 = 0, m01 = 0;
  for (int y = -15; y <= 15; ++y) {
    for (int x = -15; x <= 15; ++x) {
      if (x * x + y * y > 15 * 16) continue;
      const int grey = pixels[static_cast<size_t>((18 + y) * kWidth_px + 60 + x)];
      m10 += x * grey;
      m01 += y * grey;
    }
  }
  const PatchMoments moments =
      BestPixelKernels().patch_moments(pixels.data() + 18 * kWidth_px + 60, kWidth_px);
  EXPECT_EQ(moments.m10, m10);
  EXPECT_EQ(moments.m01, m01);
}

struct PatchAndStrip {
  GreyPatch patch;
  GreyStrip strip;
};

// Draws grey values up to `most`, also where they must not count.
PatchAndStrip RandomPatchAndStrip(uint64_t seed, uint64_t most_patch, uint64_t most_strip) {
  std::mt19937_64 random(seed);
  PatchAndStrip made;
  for (auto& row : made.patch) {
    for (int16_t& pixel : row) pixel = static_cast<int16_t>(random() % (most_patch + 1));
  }
  for (auto& row : made.strip) {
    for (int16_t& pixel : row) pixel = static_cast<int16_t>(random() % (most_strip + 1));
  }
  return made;
}

int StripDifferenceByDefinition(const PatchAndStrip& of, size_t shift) {
  double mean = 0;
  for (size_t v = 0; v < kGreySide_px; ++v) {
    for (size_t u = 0; u < kGreySide_px; ++u) mean += of.strip[v][u + shift] - of.patch[v][u];
  }
  const auto bias = static_cast<int>(std::lround(mean / (kGreySide_px * kGreySide_px)));
  int sum = 0;
  for (size_t v = 0; v < kGreySide_px; ++v) {
    for (size_t u = 0; u < kGreySide_px; ++u) {
      sum += std::abs(of.strip[v][u + shift] - of.patch[v][u] - bias);
    }
  }
  return sum;
}

TEST(PixelKernelsTest, StripDifferencesFollowTheDefinition) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    // Dark pictures meet bright ones, and the other way.
    const PatchAndStrip given =
        RandomPatchAndStrip(seed, seed % 3 == 1 ? 5 : 255, seed % 3 == 2 ? 5 : 255);
    for (const PixelKernels* kernels : {&PortablePixelKernels(), &BestPixelKernels()}) {
      std::array<int, kStripShifts> differences;
      kernels->strip_differences(given.patch, given.strip, differences);
      for (size_t shift = 0; shift < kStripShifts; ++shift) {
        ASSERT_EQ(differences[shift], StripDifferenceByDefinition(given, shift)) << seed;
      }
    }
  }
}

TEST(PixelKernelsTest, OfEqualNeighboursOneIsTheMaximum) {
  const uint8_t none[6] = {};
  const uint8_t row[6] = {0, 0, 9, 9, 0, 0};
  uint8_t maxima[6] = {};
  BestPixelKernels().fast_maxima(none, row, none, 1, 5, maxima);
  EXPECT_EQ(maxima[2], 9);
  EXPECT_EQ(maxima[3], 0);
}

}  // namespace
}  // namespace corbslam
