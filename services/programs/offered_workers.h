// Finds the fusion workers that stores of one database offer to each other.
#ifndef CORBSLAM_SERVICES_PROGRAMS_OFFERED_WORKERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_OFFERED_WORKERS_H_

#include <set>
#include <string>
#include <vector>

#include "map_store/fleet/directory.h"

namespace corbslam::services {

// Returns the addresses of the workers that other stores offer and this machine may reach, each
// once: those that live and are not this one's by `own`. Workers on a loopback address are offered
// to stores of their machine alone.
std::set<std::string> OfferedWorkers(const std::vector<map_store::DirectoryStore>& stores,
                                     const std::vector<std::string>& own,
                                     const std::string& machine);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_OFFERED_WORKERS_H_
