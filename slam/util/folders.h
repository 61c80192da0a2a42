// Makes and finds folders that people name.
#ifndef CORBSLAM_SLAM_UTIL_FOLDERS_H_
#define CORBSLAM_SLAM_UTIL_FOLDERS_H_

#include <filesystem>
#include <string>

#include "absl/status/status.h"

namespace corbslam {

// Makes the folder and those above it; it may exist already. UNAVAILABLE names the path.
absl::Status MakeFolder(const std::string& path);
// Checks that nothing is in the folder, or that there is none: what is written there belongs
// together. FAILED_PRECONDITION names the folder.
absl::Status CheckNewFolder(const std::string& path);

// Returns the path itself, or the nearest folder above it that is there.
std::filesystem::path NearestThere(const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_FOLDERS_H_
