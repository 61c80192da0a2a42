// abseil 20220623 ships no status macros; these are the two that everybody expects.
#ifndef CORBSLAM_SLAM_UTIL_STATUS_MACROS_H_
#define CORBSLAM_SLAM_UTIL_STATUS_MACROS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

#define CORBSLAM_CONCAT_INNER(a, b) a##b
#define CORBSLAM_CONCAT(a, b) CORBSLAM_CONCAT_INNER(a, b)

// Returns from the enclosing function when `expression` is not OK.
#define RETURN_IF_ERROR(expression)                                                           \
  do {                                                                                        \
    if (absl::Status status_macro_ = (expression); !status_macro_.ok()) return status_macro_; \
  } while (false)

// ASSIGN_OR_RETURN(auto value, Compute()): assigns the value, or returns the error.
#define ASSIGN_OR_RETURN(target, expression) \
  ASSIGN_OR_RETURN_INNER(CORBSLAM_CONCAT(status_or_, __LINE__), target, expression)
#define ASSIGN_OR_RETURN_INNER(status_or, target, expression) \
  auto status_or = (expression);                              \
  if (!status_or.ok()) return std::move(status_or).status();  \
  target = std::move(status_or).value()

#endif  // CORBSLAM_SLAM_UTIL_STATUS_MACROS_H_
