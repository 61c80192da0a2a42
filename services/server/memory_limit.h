// Finds how much memory the process may have: its container's limit, or the machine's memory.
#ifndef CORBSLAM_SERVICES_SERVER_MEMORY_LIMIT_H_
#define CORBSLAM_SERVICES_SERVER_MEMORY_LIMIT_H_

#include <cstdint>
#include <string>

namespace corbslam::services {

// Returns the least of the machine's memory and the limits of the control groups that hold the
// process (version 2, and 1 as containers see it). `root` stands before all paths, for tests.
uint64_t MemoryLimitBytes(const std::string& root = "");

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_MEMORY_LIMIT_H_
