// Measures what this process has used so far.
#ifndef CORBSLAM_SERVICES_SERVER_PROCESS_USAGE_H_
#define CORBSLAM_SERVICES_SERVER_PROCESS_USAGE_H_

#include <cstdint>

namespace corbslam::services {

struct ProcessUsage {
  uint64_t peak_rss_bytes = 0;
  double cpu_s = 0;
};
ProcessUsage GetProcessUsage();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_PROCESS_USAGE_H_
