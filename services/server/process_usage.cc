#include "services/server/process_usage.h"

#include <sys/resource.h>

#include <fstream>
#include <limits>
#include <string>

namespace corbslam::services {
namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

// Reads the most memory so far from /proc: getrusage's peak would include that of the program that
// started this one.
uint64_t ReadPeakBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    uint64_t kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
    status.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

}  // namespace

ProcessUsage GetProcessUsage() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return {ReadPeakBytes(), Seconds(usage.ru_utime) + Seconds(usage.ru_stime)};
}

}  // namespace corbslam::services
