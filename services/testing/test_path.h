// Names files of tests.
#ifndef CORBSLAM_SERVICES_TESTING_TEST_PATH_H_
#define CORBSLAM_SERVICES_TESTING_TEST_PATH_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"

namespace corbslam::services {

// Returns a path in the folder for such files that no other test uses: tests run side by side.
inline std::string TestPath(const std::string& name) {
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string own =
      absl::StrCat("corbslam_", test->test_suite_name(), "_", test->name(), "_", name);
  std::replace(own.begin(), own.end(), '/', '_');
  return ::testing::TempDir() + "/" + own;
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TESTING_TEST_PATH_H_
