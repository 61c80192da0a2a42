#include "map_store/rocks/durable_mark.h"

#include <filesystem>
#include <fstream>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {

void WriteDurableMark(const std::string& folder, uint64_t position) {
  const std::string path = absl::StrCat(folder, "/", kDurableMark);
  const std::string written = path + ".tmp";
  std::error_code error;
  {
    std::ofstream file(written, std::ios::trunc);
    // Twice, so that a damaged mark is not believed.
    file << position << ' ' << position << '\n';
    file.close();
    if (!file) {
      std::filesystem::remove(written, error);
      return;
    }
  }
  std::filesystem::rename(written, path, error);
}

uint64_t ReadDurableMark(const std::string& folder) {
  std::ifstream file(absl::StrCat(folder, "/", kDurableMark));
  uint64_t position = 0;
  uint64_t again = 0;
  char end = 0;
  const bool read = file >> position >> again && file.get(end) && end == '\n';
  return read && position == again ? position : 0;
}

}  // namespace corbslam::map_store
