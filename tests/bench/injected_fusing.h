// Fuses two synthetic local maps by true and wrong overlaps.
#ifndef CORBSLAM_TESTS_BENCH_INJECTED_FUSING_H_
#define CORBSLAM_TESTS_BENCH_INJECTED_FUSING_H_

#include <cstdint>

#include "absl/status/statusor.h"

namespace corbslam::tests {

struct InjectionOptions {
  double wrong_share = 0;  // Share of all overlaps.
  // True: all overlaps call for one fusing. False: one comes after the other, a true one first,
  // each with those that were accepted before it.
  bool at_once = false;
  uint64_t seed = 1;
};

struct InjectionResult {
  int true_overlaps = 0;
  int wrong_overlaps = 0;
  int true_accepted = 0;
  int wrong_accepted = 0;
  double ate_m = 0;  // Error of both maps together; 0 where they were not fused.
};

// The true overlaps are what VerifyPlace finds where the maps meet; the wrong ones name keyframes
// more than 10 m apart, with 30 pairs of points that have nothing to do with each other.
absl::StatusOr<InjectionResult> FuseWithInjection(const InjectionOptions& options);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_INJECTED_FUSING_H_
