// Measures how much memory the process has.
#ifndef CORBSLAM_SLAM_UTIL_RESIDENT_MEMORY_H_
#define CORBSLAM_SLAM_UTIL_RESIDENT_MEMORY_H_

#include <cstdint>

namespace corbslam {

// Returns what the kernel counts as resident; 0 where it does not say.
uint64_t ResidentBytes();

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_RESIDENT_MEMORY_H_
