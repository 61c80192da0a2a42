// Says what this process has used of processors, and how many it may use.
#ifndef CORBSLAM_MAP_STORE_PROCESS_PROCESS_LOAD_H_
#define CORBSLAM_MAP_STORE_PROCESS_PROCESS_LOAD_H_

#include <string>

namespace corbslam::map_store {

// Returns processor seconds since the process began, in its own code and in the kernel.
double ProcessorSeconds();

// Returns how many processors its threads may use at once: those that they may run on, or the share
// of them that a control group (version 2) allows, as 1.5. `root` stands for / in tests.
double UsableProcessors(const std::string& root = "");

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_PROCESS_LOAD_H_
