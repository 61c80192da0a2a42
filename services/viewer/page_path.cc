#include "services/viewer/page_path.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace corbslam::services {

namespace fs = std::filesystem;

std::string DefaultPagePath() {
  if (const char* path = std::getenv("CORBSLAM_VIEWER_PAGE"); path != nullptr && *path != '\0') {
    return path;
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto installed = program.parent_path().parent_path() / "share/corbslam/viewer";
    if (fs::exists(installed, error)) return installed.string();
  }
  return CORBSLAM_BUILT_PAGE;
}

}  // namespace corbslam::services
