// The kernels of FAST, for pixel_kernels.cc to build for each instruction set.
#ifndef CORBSLAM_SLAM_FEATURES_FAST_KERNELS_H_
#define CORBSLAM_SLAM_FEATURES_FAST_KERNELS_H_

#include <cstdint>
#include <cstring>

// Every kernel is written once, as a plain loop that compilers turn into vector code, and inlined
// into a function for each instruction set.
#define CORBSLAM_KERNEL [[gnu::always_inline]] inline

namespace corbslam::kernels {

CORBSLAM_KERNEL uint8_t Min(uint8_t a, uint8_t b) { return a < b ? a : b; }
CORBSLAM_KERNEL uint8_t Max(uint8_t a, uint8_t b) { return a > b ? a : b; }

// Returns the largest, over the 16 arcs of 9 pixels, of an arc's darkest pixel; with Less and
// Greater exchanged, the smallest of an arc's brightest. Two arcs share each run of 8.
template <uint8_t (*Least)(uint8_t, uint8_t), uint8_t (*Most)(uint8_t, uint8_t)>
CORBSLAM_KERNEL uint8_t BestArc(const uint8_t (&p)[16]) {
  uint8_t pair[8];
  for (int i = 0; i < 8; ++i) pair[i] = Least(p[2 * i + 1], p[(2 * i + 2) % 16]);
  uint8_t four[8];
  for (int i = 0; i < 8; ++i) four[i] = Least(pair[i], pair[(i + 1) % 8]);
  uint8_t best = 0;
  for (int i = 0; i < 8; ++i) {
    const uint8_t eight = Least(four[i], four[(i + 2) % 8]);
    const uint8_t nine = Least(eight, Most(p[2 * i], p[(2 * i + 9) % 16]));
    best = i == 0 ? nine : Most(best, nine);
  }
  return best;
}

// Nine pixels in a row on the circle of 16 hold at least two neighbours among its topmost,
// leftmost, lowest and rightmost: a score is at most what both of such a pair reach. Whether any of
// a block's pixels may have one above `limit`; in a sky, on a street or on a wall hardly any has.
constexpr int kBlock = 32;
CORBSLAM_KERNEL bool MayHaveScore(const uint8_t* top, const uint8_t* middle, const uint8_t* bottom,
                                  uint8_t limit) {
  uint8_t most = 0;
  for (int x = 0; x < kBlock; ++x) {
    const uint8_t centre = middle[x];
    const uint8_t bright = Min(Max(top[x], bottom[x]), Max(middle[x - 3], middle[x + 3]));
    const uint8_t dark = Max(Min(top[x], bottom[x]), Min(middle[x - 3], middle[x + 3]));
    const uint8_t above = static_cast<uint8_t>(Max(bright, centre) - centre);
    const uint8_t below = static_cast<uint8_t>(centre - Min(dark, centre));
    most = Max(most, Max(above, below));
  }
  return most > limit;
}

CORBSLAM_KERNEL void FastScoresOf(const uint8_t* const rows[7], int begin, int end, uint8_t limit,
                                  uint8_t* __restrict scores) {
  const uint8_t* __restrict const r0 = rows[0];
  const uint8_t* __restrict const r1 = rows[1];
  const uint8_t* __restrict const r2 = rows[2];
  const uint8_t* __restrict const r3 = rows[3];
  const uint8_t* __restrict const r4 = rows[4];
  const uint8_t* __restrict const r5 = rows[5];
  const uint8_t* __restrict const r6 = rows[6];
  for (int x = begin; x < end; ++x) {
    const uint8_t p[16] = {r0[x],     r0[x + 1], r1[x + 2], r2[x + 3], r3[x + 3], r4[x + 3],
                           r5[x + 2], r6[x + 1], r6[x],     r6[x - 1], r5[x - 2], r4[x - 3],
                           r3[x - 3], r2[x - 3], r1[x - 2], r0[x - 1]};
    const uint8_t centre = r3[x];
    const uint8_t bright = BestArc<Min, Max>(p);
    const uint8_t dark = BestArc<Max, Min>(p);
    const uint8_t above = static_cast<uint8_t>(Max(bright, centre) - centre);
    const uint8_t below = static_cast<uint8_t>(centre - Min(dark, centre));
    const uint8_t score = Max(above, below);
    scores[x] = score > limit ? score : uint8_t{0};
  }
}

CORBSLAM_KERNEL void FastScores(const uint8_t* const rows[7], int begin, int end, int threshold,
                                uint8_t* scores) {
  const uint8_t limit = static_cast<uint8_t>(threshold);
  // Runs of blocks that may have scores are done together.
  int first = begin;
  int x = begin;
  for (; x + kBlock <= end; x += kBlock) {
    if (MayHaveScore(rows[0] + x, rows[3] + x, rows[6] + x, limit)) continue;
    FastScoresOf(rows, first, x, limit, scores);
    std::memset(scores + x, 0, kBlock);
    first = x + kBlock;
  }
  FastScoresOf(rows, first, end, limit, scores);
}

CORBSLAM_KERNEL void FastMaxima(const uint8_t* __restrict above, const uint8_t* __restrict row,
                                const uint8_t* __restrict below, int begin, int end,
                                uint8_t* __restrict maxima) {
  for (int x = begin; x < end; ++x) {
    const uint8_t before = Max(Max(above[x - 1], above[x]), Max(above[x + 1], row[x - 1]));
    const uint8_t after = Max(Max(below[x - 1], below[x]), Max(below[x + 1], row[x + 1]));
    const uint8_t score = row[x];
    const uint8_t kept = score > before ? score : uint8_t{0};
    maxima[x] = score >= after ? kept : uint8_t{0};
  }
}

}  // namespace corbslam::kernels

#endif  // CORBSLAM_SLAM_FEATURES_FAST_KERNELS_H_
