// Knows how many files, and so connections, this process may have.
#ifndef CORBSLAM_SERVICES_RUNTIME_FILE_LIMIT_H_
#define CORBSLAM_SERVICES_RUNTIME_FILE_LIMIT_H_

#include <cstddef>

#include "services/runtime/connection_book.h"

namespace corbslam::services {

// Raises the limit of open files to what the system lets this process have. Programs call it first.
void RaiseFileLimit();

// Returns the limit of open files as it is now: others may change it (prlimit).
size_t FileLimit();

// Returns the limits for one port of a process with this limit of files: half of the files stay for
// the journal and all else. One host gets a quarter of the connections, yet at least 64 where there
// are so many.
ConnectionLimits LimitsWithin(size_t file_limit, const ConnectionLimits& wanted = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_FILE_LIMIT_H_
