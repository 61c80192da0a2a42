// Describes other processes as people know them.
#ifndef CORBSLAM_SLAM_UTIL_PROCESS_NAME_H_
#define CORBSLAM_SLAM_UTIL_PROCESS_NAME_H_

#include <sys/types.h>

#include <string>

namespace corbslam {

// Returns "process 4711 (map_store)"; without the program where the system doesn't tell it; "this
// process itself" for one's own.
std::string DescribeProcess(pid_t pid);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_PROCESS_NAME_H_
