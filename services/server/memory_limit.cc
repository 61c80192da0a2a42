#include "services/server/memory_limit.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "absl/strings/numbers.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

uint64_t MachineMemory() {
  return static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

// Returns the number in a file, or `otherwise` if that is less; "max", no file and no number are no
// limit.
uint64_t LimitIn(const std::string& file, uint64_t otherwise) {
  std::string word;
  std::ifstream(file) >> word;
  uint64_t limit = 0;
  return absl::SimpleAtoi(word, &limit) && limit > 0 ? std::min(limit, otherwise) : otherwise;
}

// Returns the process's own group, from the root of version 2's tree; "/" in a container of its
// own.
std::string OwnGroup(const std::string& root) {
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    absl::string_view path = line;
    if (absl::ConsumePrefix(&path, "0::")) return std::string(path);
  }
  return "/";
}

}  // namespace

uint64_t MemoryLimitBytes(const std::string& root) {
  uint64_t limit = MachineMemory();
  // A group has no more memory than each of the groups that it lies in.
  const std::string tree = root + "/sys/fs/cgroup";
  for (std::filesystem::path group = OwnGroup(root);; group = group.parent_path()) {
    limit = LimitIn(tree + group.string() + "/memory.max", limit);
    if (group == group.parent_path()) break;
  }
  return LimitIn(tree + "/memory/memory.limit_in_bytes", limit);
}

}  // namespace corbslam::services
