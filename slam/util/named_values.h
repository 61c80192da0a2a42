// The names that people give to the values of an enum, in one table for all who read or write them.
#ifndef CORBSLAM_SLAM_UTIL_NAMED_VALUES_H_
#define CORBSLAM_SLAM_UTIL_NAMED_VALUES_H_

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace corbslam {

template <typename Value>
struct NamedValue {
  const char* name;
  Value value;
};

template <typename Value, size_t kCount>
using NamedValues = std::array<NamedValue<Value>, kCount>;

// Returns nullopt where no value has the name.
template <typename Value, size_t kCount>
std::optional<Value> FindNamed(const NamedValues<Value, kCount>& table, absl::string_view name) {
  for (const NamedValue<Value>& entry : table) {
    if (entry.name == name) return entry.value;
  }
  return std::nullopt;
}

// Returns "" for a value that has no name.
template <typename Value, size_t kCount>
const char* NameOf(const NamedValues<Value, kCount>& table, Value value) {
  for (const NamedValue<Value>& entry : table) {
    if (entry.value == value) return entry.name;
  }
  return "";
}

template <typename Value, size_t kCount>
std::string JoinNames(const NamedValues<Value, kCount>& table, absl::string_view between) {
  std::string names;
  for (const NamedValue<Value>& entry : table) {
    absl::StrAppend(&names, names.empty() ? "" : between, entry.name);
  }
  return names;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_NAMED_VALUES_H_
