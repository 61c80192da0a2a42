// Makes INVALID_ARGUMENT errors with the field, its value and its limit.
#ifndef CORBSLAM_SERVICES_CONVERT_ERRORS_H_
#define CORBSLAM_SERVICES_CONVERT_ERRORS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

inline absl::Status BadLength(absl::string_view field, int64_t length, int64_t expected) {
  return absl::InvalidArgumentError(
      absl::StrCat(field, " has ", length, " entries, must have ", expected));
}

template <typename T, typename Limit>
absl::Status OutOfRange(absl::string_view field, T value, Limit low, Limit high) {
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be in [", low, ", ", high, "]"));
}

// Returns the same error with "where: " before its message.
inline absl::Status Locate(const absl::Status& status, absl::string_view where) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(where, ": ", status.message()));
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_ERRORS_H_
