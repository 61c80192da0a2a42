// Says who may include whom: the layers of docs/architecture.md.
#ifndef CORBSLAM_TESTS_INTEGRATION_INCLUDE_RULES_H_
#define CORBSLAM_TESTS_INTEGRATION_INCLUDE_RULES_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace corbslam::tests {

// Returns one line for each include of the file at `path` (relative to the repository) that its
// place in the layers does not allow: "path:line: includes X: why".
std::vector<std::string> FindForbiddenIncludes(absl::string_view path, absl::string_view text);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_INTEGRATION_INCLUDE_RULES_H_
