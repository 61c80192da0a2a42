#include "slam/util/lock_holder.h"

#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <fstream>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "slam/util/process_name.h"

namespace corbslam {
namespace {

// Returns the file's name in a line of /proc/locks: major and minor number of its device, and its
// inode.
std::string NameOf(const struct stat& file) {
  return absl::StrFormat("%02x:%02x:%d", major(file.st_dev), minor(file.st_dev), file.st_ino);
}

}  // namespace

std::optional<pid_t> FindLockHolder(const std::string& path) {
  struct stat file;
  if (stat(path.c_str(), &file) != 0) return std::nullopt;
  const std::string name = NameOf(file);
  std::ifstream locks("/proc/locks");
  // A line is "1: POSIX  ADVISORY  WRITE 3568 fd:00:2531452 0 EOF", or "1: -> ..." for a process
  // that waits.
  for (std::string line; std::getline(locks, line);) {
    const std::vector<std::string> fields = absl::StrSplit(line, ' ', absl::SkipEmpty());
    pid_t pid = 0;
    if (fields.size() < 6 || fields[5] != name) continue;
    if (absl::SimpleAtoi(fields[4], &pid) && pid > 0) return pid;
  }
  return std::nullopt;
}

std::string DescribeLockHolder(const std::string& path) {
  const std::optional<pid_t> holder = FindLockHolder(path);
  if (holder.has_value()) return absl::StrCat(DescribeProcess(*holder), " has it");
  return "another process has it; which one can't be told from here (another container or "
         "machine?)";
}

}  // namespace corbslam
