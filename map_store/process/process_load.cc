#include "map_store/process/process_load.h"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>

namespace corbslam::map_store {
namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

}  // namespace

double ProcessorSeconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
}

double UsableProcessors(const std::string& root) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  double processors = 1;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) == 0) processors = CPU_COUNT(&allowed);
  // In a container its own group is the root of the tree. "max" instead of a number is no limit.
  std::ifstream limit(root + "/sys/fs/cgroup/cpu.max");
  double quota = 0;
  double period = 0;
  if (limit >> quota >> period && period > 0 && quota > 0) {
    processors = std::min(processors, quota / period);
  }
  return processors;
}

}  // namespace corbslam::map_store
