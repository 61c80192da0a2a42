// Eight numbers at a time, in the compilers' vector types: one code for every instruction set.
#ifndef CORBSLAM_SERVICES_SIMULATION_LANES_H_
#define CORBSLAM_SERVICES_SIMULATION_LANES_H_

#include <cstdint>
#include <cstring>

#include "services/simulation/eight.h"
#if !defined(__x86_64__)
#include "services/simulation/lane_pairs.h"
#endif

namespace corbslam {

// These functions must end up inside the ones that are compiled for each instruction set.
#define CORBSLAM_LANES [[gnu::always_inline]] inline

#if defined(__x86_64__)

using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));
using Uints = uint32_t __attribute__((vector_size(32)));

CORBSLAM_LANES Floats ToFloats(const Ints& x) { return __builtin_convertvector(x, Floats); }
// Rounds towards zero.
CORBSLAM_LANES Ints ToInts(const Floats& x) { return __builtin_convertvector(x, Ints); }
// Returns a where the mask is set, b where it is 0.
CORBSLAM_LANES Floats Select(const Ints& mask, const Floats& a, const Floats& b) {
  return mask ? a : b;
}
CORBSLAM_LANES Ints Select(const Ints& mask, const Ints& a, const Ints& b) { return mask ? a : b; }
CORBSLAM_LANES Floats Ramp() { return Floats{0, 1, 2, 3, 4, 5, 6, 7}; }

#else

using Floats = LanePair<float>;
using Ints = LanePair<int32_t>;
using Uints = LanePair<uint32_t>;

CORBSLAM_LANES Floats ToFloats(const Ints& x) {
  return {__builtin_convertvector(x.low, Floats::Four),
          __builtin_convertvector(x.high, Floats::Four)};
}
CORBSLAM_LANES Ints ToInts(const Floats& x) {
  return {__builtin_convertvector(x.low, Ints::Four), __builtin_convertvector(x.high, Ints::Four)};
}
CORBSLAM_LANES Floats Select(const Ints& mask, const Floats& a, const Floats& b) {
  return {mask.low ? a.low : b.low, mask.high ? a.high : b.high};
}
CORBSLAM_LANES Ints Select(const Ints& mask, const Ints& a, const Ints& b) {
  return {mask.low ? a.low : b.low, mask.high ? a.high : b.high};
}
CORBSLAM_LANES Floats Ramp() { return {Floats::Four{0, 1, 2, 3}, Floats::Four{4, 5, 6, 7}}; }

#endif

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
CORBSLAM_LANES Floats Least(const Floats& a, const Floats& b) { return Select(a < b, a, b); }
CORBSLAM_LANES Floats Most(const Floats& a, const Floats& b) { return Select(a > b, a, b); }
CORBSLAM_LANES Floats Clamp01(const Floats& x) { return Most(Least(x, All(1)), All(0)); }
CORBSLAM_LANES Floats Mix(const Floats& a, const Floats& b, const Floats& share_of_b) {
  return a + (b - a) * share_of_b;
}
CORBSLAM_LANES Ints FloorToInts(const Floats& x) {
  const Ints truncated = ToInts(x);
  // A comparison is -1 where it holds.
  return truncated + (ToFloats(truncated) > x);
}
CORBSLAM_LANES Floats Magnitude(const Floats& x) { return Select(x < 0, -x, x); }

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_LANES_H_
