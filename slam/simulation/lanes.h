// Eight numbers at a time, in the compilers' vector types: one code for every instruction set.
#ifndef CORBSLAM_SLAM_SIMULATION_LANES_H_
#define CORBSLAM_SLAM_SIMULATION_LANES_H_

#include <cstdint>
#include <cstring>

#include "slam/simulation/eight.h"

namespace corbslam {

using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));
using Uints = uint32_t __attribute__((vector_size(32)));

// These functions must end up inside the ones that are compiled for each instruction set.
#define CORBSLAM_LANES [[gnu::always_inline]] inline

CORBSLAM_LANES Floats Load(const Eight<float>& from) {
  Floats to;
  std::memcpy(&to, from.lanes.data(), sizeof(to));
  return to;
}
CORBSLAM_LANES Ints Load(const Eight<int32_t>& from) {
  Ints to;
  std::memcpy(&to, from.lanes.data(), sizeof(to));
  return to;
}
CORBSLAM_LANES void Store(const Floats& from, Eight<float>& to) {
  std::memcpy(to.lanes.data(), &from, sizeof(from));
}
CORBSLAM_LANES void Store(const Ints& from, Eight<int32_t>& to) {
  std::memcpy(to.lanes.data(), &from, sizeof(from));
}

CORBSLAM_LANES Floats All(float value) { return Floats{} + value; }
CORBSLAM_LANES Floats Least(const Floats& a, const Floats& b) { return a < b ? a : b; }
CORBSLAM_LANES Floats Most(const Floats& a, const Floats& b) { return a > b ? a : b; }
CORBSLAM_LANES Floats Clamp01(const Floats& x) { return Most(Least(x, All(1)), All(0)); }
CORBSLAM_LANES Floats Mix(const Floats& a, const Floats& b, const Floats& share_of_b) {
  return a + (b - a) * share_of_b;
}
CORBSLAM_LANES Ints FloorToInts(const Floats& x) {
  const Ints truncated = __builtin_convertvector(x, Ints);
  // A comparison is -1 where it holds.
  return truncated + (__builtin_convertvector(truncated, Floats) > x);
}
CORBSLAM_LANES Floats ToFloats(const Ints& x) { return __builtin_convertvector(x, Floats); }
CORBSLAM_LANES Floats Magnitude(const Floats& x) { return x < 0 ? -x : x; }

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_LANES_H_
