// Spreads the bits of a number.
#ifndef CORBSLAM_SLAM_UTIL_MIXED_BITS_H_
#define CORBSLAM_SLAM_UTIL_MIXED_BITS_H_

#include <cstdint>

namespace corbslam {

// Numbers that lie this far apart are well mixed by MixBits.
inline constexpr uint64_t kGoldenGamma = 0x9e3779b97f4a7c15u;

// The finaliser of SplitMix64 (Steele et al., "Fast splittable pseudorandom number generators",
// OOPSLA 2014): each bit of the result depends on all bits of the number, and no two numbers give
// the same.
constexpr uint64_t MixBits(uint64_t number) {
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9u;
  number = (number ^ (number >> 27)) * 0x94d049bb133111ebu;
  return number ^ (number >> 31);
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_MIXED_BITS_H_
