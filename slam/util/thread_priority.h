// Gives threads less of a processor than others have.
#ifndef CORBSLAM_SLAM_UTIL_THREAD_PRIORITY_H_
#define CORBSLAM_SLAM_UTIL_THREAD_PRIORITY_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// Raises the niceness of this thread, and of those that it will start, by `steps` above what it has
// now (a thread begins with that of the one that started it), up to the 19 that there is. So it is
// lower than its process however that was started, as by `nice`. An error names what the system
// says; the thread can go on with what it has.
absl::Status LowerThreadPriority(int steps);

// Does so for a thread for which no robot waits. If it can't be, the log says that `what` may hold
// up robots, and the thread goes on.
void StepBehindRobots(int steps, absl::string_view what);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_THREAD_PRIORITY_H_
