#include "services/programs/default_vocabulary.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace corbslam::services {

std::string DefaultVocabularyPath() {
  if (const char* path = std::getenv("CORBSLAM_VOCABULARY"); path != nullptr && *path != '\0') {
    return path;
  }
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto installed = program.parent_path().parent_path() / "share/corbslam/corbslam.voc";
    if (std::filesystem::exists(installed, error)) return installed.string();
  }
  return CORBSLAM_SOURCE_VOCABULARY;
}

}  // namespace corbslam::services
