// Eight numbers as two of the processor's vectors of four, for lanes.h where 32 bytes are no vector
// of any processor (arm64): gcc takes comparisons, choices and conversions of vectors that are too
// long for the processor apart into single numbers. The operators are those of the compilers'
// vectors.
#ifndef CORBSLAM_SERVICES_SIMULATION_LANE_PAIRS_H_
#define CORBSLAM_SERVICES_SIMULATION_LANE_PAIRS_H_

#include <cstdint>
#include <type_traits>

namespace corbslam {

template <typename T>
struct LanePair {
  using Four [[gnu::vector_size(16)]] = T;
  Four low;
  Four high;

  LanePair() = default;
  LanePair(T all) : low(Four{} + all), high(Four{} + all) {}  // NOLINT: numbers stand for lanes.
  LanePair(const Four& lower, const Four& upper) : low(lower), high(upper) {}
  // Takes the bits as they are.
  template <typename Other>
  explicit LanePair(const LanePair<Other>& bits) : low((Four)bits.low), high((Four)bits.high) {}

  template <typename Index>
  T operator[](Index lane) const {
    return lane < 4 ? low[lane] : high[lane - 4];
  }
};

// Both operands are pairs, or one is a number; OPERATOR is the compilers' own of each half.
#define CORBSLAM_ON_HALVES(OPERATOR, RESULT)                                                    \
  template <typename T>                                                                         \
  [[gnu::always_inline]] inline LanePair<RESULT> operator OPERATOR(const LanePair<T>& a,        \
                                                                   const LanePair<T>& b) {      \
    return {a.low OPERATOR b.low, a.high OPERATOR b.high};                                      \
  }                                                                                             \
  template <typename T>                                                                         \
  [[gnu::always_inline]] inline LanePair<RESULT> operator OPERATOR(const LanePair<T>& a,        \
                                                                   std::type_identity_t<T> b) { \
    return a OPERATOR LanePair<T>(b);                                                           \
  }                                                                                             \
  template <typename T>                                                                         \
  [[gnu::always_inline]] inline LanePair<RESULT> operator OPERATOR(std::type_identity_t<T> a,   \
                                                                   const LanePair<T>& b) {      \
    return LanePair<T>(a) OPERATOR b;                                                           \
  }
#define CORBSLAM_ASSIGNED_ON_HALVES(OPERATOR)                                                  \
  CORBSLAM_ON_HALVES(OPERATOR, T)                                                              \
  template <typename T>                                                                        \
  [[gnu::always_inline]] inline LanePair<T>& operator OPERATOR##=(LanePair<T>& a,              \
                                                                  const LanePair<T>& b) {      \
    return a = a OPERATOR b;                                                                   \
  }                                                                                            \
  template <typename T>                                                                        \
  [[gnu::always_inline]] inline LanePair<T>& operator OPERATOR##=(LanePair<T>& a,              \
                                                                  std::type_identity_t<T> b) { \
    return a = a OPERATOR b;                                                                   \
  }
CORBSLAM_ASSIGNED_ON_HALVES(+)
CORBSLAM_ASSIGNED_ON_HALVES(-)
CORBSLAM_ASSIGNED_ON_HALVES(*)
CORBSLAM_ASSIGNED_ON_HALVES(/)
CORBSLAM_ASSIGNED_ON_HALVES(&)
CORBSLAM_ASSIGNED_ON_HALVES(|)
CORBSLAM_ASSIGNED_ON_HALVES(^)
CORBSLAM_ASSIGNED_ON_HALVES(>>)
// -1 where it holds.
CORBSLAM_ON_HALVES(<, int32_t)
CORBSLAM_ON_HALVES(<=, int32_t)
CORBSLAM_ON_HALVES(>, int32_t)
CORBSLAM_ON_HALVES(>=, int32_t)
#undef CORBSLAM_ASSIGNED_ON_HALVES
#undef CORBSLAM_ON_HALVES

template <typename T>
[[gnu::always_inline]] inline LanePair<T> operator-(const LanePair<T>& a) {
  return {-a.low, -a.high};
}

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_LANE_PAIRS_H_
