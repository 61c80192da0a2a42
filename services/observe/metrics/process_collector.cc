#include "services/observe/metrics/process_collector.h"

#include <filesystem>
#include <system_error>

#include "services/observe/metrics/families.h"
#include "services/server/process_usage.h"
#include "slam/util/resident_memory.h"

namespace corbslam::services {
namespace {

double OpenFiles() {
  std::error_code error;
  int count = 0;
  for (std::filesystem::directory_iterator file("/proc/self/fd", error), end; !error && file != end;
       file.increment(error)) {
    ++count;
  }
  return count;
}

}  // namespace

std::vector<prometheus::MetricFamily> ProcessCollector::Collect() const {
  Families families;
  families.Gauge("corbslam_build_info", "Which program this is, in which version; always 1.", 1,
                 {{"program", program_}, {"version", CORBSLAM_VERSION}});
  families.Counter("process_cpu_seconds_total", "Processor time, user and system.",
                   GetProcessUsage().cpu_s);
  families.Gauge("process_resident_memory_bytes", "Memory that is resident.",
                 static_cast<double>(ResidentBytes()));
  families.Gauge("process_start_time_seconds", "When the process began, since 1970.",
                 absl::ToDoubleSeconds(started_ - absl::UnixEpoch()));
  families.Gauge("process_open_fds", "Open files and connections.", OpenFiles());
  return families.Take();
}

}  // namespace corbslam::services
