#include "services/observe/metrics/process_collector.h"

#include <filesystem>
#include <system_error>

#include "services/observe/metrics/families.h"
#include "services/runtime/file_limit.h"
#include "services/server/process_usage.h"
#include "services/server/served_ports.h"
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

void AddPorts(Families& families) {
  families.Gauge("corbslam_takes_connections",
                 "1 as long as the program reaches its own port; 0: nobody else does either.",
                 TakesConnections() ? 1 : 0);
  for (const PortState& state : ServedPorts()) {
    const ConnectionCounts& counts = state.connections;
    const MetricLabels port = {{"port", state.port}};
    families.Gauge("corbslam_connections_open", "Connections at this moment.",
                   static_cast<double>(counts.open), port);
    families.Gauge("corbslam_connections_busy", "Connections on which something is under way.",
                   static_cast<double>(counts.busy), port);
    families.Gauge("corbslam_connections_limit", "Connections that there may be at one time.",
                   static_cast<double>(counts.limits.all), port);
    families.Counter("corbslam_connections_refused_total",
                     "Connections that were refused, since all others were busy.",
                     static_cast<double>(counts.refused), port);
    families.Counter("corbslam_connections_made_room_total",
                     "Connections that were closed for newer ones; nothing was under way on them.",
                     static_cast<double>(counts.closed_for_room), port);
  }
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
  families.Gauge("process_max_fds", "Files and connections that there may be.",
                 static_cast<double>(FileLimit()));
  AddPorts(families);
  return families.Take();
}

}  // namespace corbslam::services
