// How likely each bit of a descriptor is, given those before it. The binary tests compare pixels of
// one smoothed patch, so that many say nearly the same: a logistic regression of each bit on all
// bits before it, learned from pictures (tests/bench/learn_bit_weights.cc), leaves about half of
// the 256 bits (docs/adr/0018-coded-features.md). Whole numbers throughout: all machines agree.
#ifndef CORBSLAM_SLAM_CODING_DESCRIPTOR_MODEL_H_
#define CORBSLAM_SLAM_CODING_DESCRIPTOR_MODEL_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "slam/features/keypoint.h"

namespace corbslam {

inline constexpr int kDescriptorBits = 256;

// Steps of a stored log-odds in one nat.
inline constexpr int kLogOddsSteps = 64;

// The weights are whole numbers modulo 2^16: the log-odds themselves are within 16 bits, sums on
// the way to them need not be.
struct BitWeights {
  // bias[k] is the log-odds that bit k is 1 if all bits before it are 0.
  std::array<uint16_t, kDescriptorBits> bias;
  // after[j][k] is what a bit j that is 1 adds to the log-odds of bit k > j; it is 0 for k <= j.
  std::array<std::array<uint16_t, kDescriptorBits>, kDescriptorBits> after;
};

// Returns the weights that ship. Another set of them makes another version of the format
// (feature_coding.h).
const BitWeights& LearnedBitWeights();

// The weights as learn_bit_weights writes them to learned_bit_weights.cc. A bias is the log-odds of
// bit k before any other is known; a weight is what a bit j adds to those of bit k > j if it is 1,
// and takes away if it is 0. Weights are in the order of j, and for each j from k = j + 1 on.
inline constexpr size_t kLearnedWeights = kDescriptorBits * (kDescriptorBits - 1) / 2;
extern const std::array<int8_t, kDescriptorBits> kLearnedBitBias;
extern const std::array<int8_t, kLearnedWeights> kLearnedBitWeights;

// 65536 / (1 + exp(-i / 4)) for i = 0 to 40; by exp() two machines could differ in the last digit.
inline constexpr std::array<uint16_t, 41> kProbabilityOfQuarters = {
    32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565,
    61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097, 65194,
    65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514,
    65519, 65523, 65526, 65528, 65530, 65531, 65532, 65533};

// The table reaches from -10 to 10 nats. Between its quarters the probability lies on a straight
// line; beyond its ends it is the one at the end.
inline constexpr int kMostLogOdds = 40 * kLogOddsSteps / 4;

// The probability in 65536ths that a bit is 1, by its log-odds as 16 bits without a sign: a table
// for each there can be, of which a few kB are in use.
using ProbabilityTable = std::array<uint16_t, 1 << 16>;
const ProbabilityTable& ProbabilitiesOfLogOdds();

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_DESCRIPTOR_MODEL_H_
