// A folder in memory for parsers that want paths.
#ifndef CORBSLAM_TESTS_FUZZ_FUZZ_FILES_H_
#define CORBSLAM_TESTS_FUZZ_FUZZ_FILES_H_

#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::tests {

// Returns this process's own folder, made when first asked for and removed at its end.
const std::string& FuzzFolder();
// Returns the path of FuzzFolder()/name, which now holds `content`. Folders in the name are made.
std::string WriteFuzzFile(const std::string& name, absl::string_view content);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FUZZ_FUZZ_FILES_H_
