#include "slam/util/process_name.h"

#include <unistd.h>

#include <fstream>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

// Returns the last segment of the command, or what the system calls the process; empty: it is gone,
// or hidden.
std::string ProgramOf(pid_t pid) {
  const std::string folder = absl::StrCat("/proc/", pid);
  std::string name;
  std::ifstream command(folder + "/cmdline");
  std::getline(command, name, '\0');
  if (name.empty()) {
    std::ifstream short_name(folder + "/comm");
    std::getline(short_name, name);
  }
  return name.substr(name.rfind('/') + 1);
}

}  // namespace

std::string DescribeProcess(pid_t pid) {
  if (pid == getpid()) return "this process itself";
  const std::string program = ProgramOf(pid);
  return program.empty() ? absl::StrCat("process ", pid)
                         : absl::StrCat("process ", pid, " (", program, ")");
}

}  // namespace corbslam
