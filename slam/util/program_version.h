// The version of the programs that this library is part of.
#ifndef CORBSLAM_SLAM_UTIL_PROGRAM_VERSION_H_
#define CORBSLAM_SLAM_UTIL_PROGRAM_VERSION_H_

namespace corbslam {

// Returns "0.1.0" and the like.
const char* CorbslamVersion();

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_PROGRAM_VERSION_H_
