// Names the cases of a parametrised test by what they say of themselves.
#ifndef CORBSLAM_SLAM_UTIL_TESTING_CASE_NAME_H_
#define CORBSLAM_SLAM_UTIL_TESTING_CASE_NAME_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/string_view.h"

namespace corbslam::testing {

// Returns the text with an underscore for whatever a test's name can't have.
inline std::string CaseName(absl::string_view text) {
  std::string name(text.empty() ? "empty" : text);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !absl::ascii_isalnum(c); }, '_');
  return name;
}

// Names cases by one of their fields: NamedBy(&Case::name).
template <typename Case, typename Text>
auto NamedBy(Text Case::*text) {
  return [text](const ::testing::TestParamInfo<Case>& info) { return CaseName(info.param.*text); };
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_UTIL_TESTING_CASE_NAME_H_
