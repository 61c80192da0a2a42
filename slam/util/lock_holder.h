// Finds out who has locked a file.
#ifndef CORBSLAM_SLAM_UTIL_LOCK_HOLDER_H_
#define CORBSLAM_SLAM_UTIL_LOCK_HOLDER_H_

#include <sys/types.h>

#include <optional>
#include <string>

namespace corbslam {

// Returns the process that holds a lock on the file (flock's or fcntl's), as /proc/locks says.
// There is none where nobody does, or it can't be seen from here: a process of another container, a
// file of another machine. It doesn't open the file, which would give up a lock of fcntl that this
// process holds.
std::optional<pid_t> FindLockHolder(const std::string& path);

// Returns "process 4711 (map_store) has it", or that it can't be told which process has it.
std::string DescribeLockHolder(const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_LOCK_HOLDER_H_
