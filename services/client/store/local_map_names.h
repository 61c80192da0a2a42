// What people call a mission's local maps.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_LOCAL_MAP_NAMES_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_LOCAL_MAP_NAMES_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "corbslam/v1/resources.pb.h"

namespace corbslam::services {

// Short names by the names of the resources: "alpha/4" is the fourth local map that alpha began,
// whatever has become of it and of the others since.
using LocalMapNames = std::map<std::string, std::string>;

// Returns the names of all local maps, those included that have become parts of others. Of a store
// that is older than such numbers the local maps are counted as they are listed, and parts are
// called as their wholes.
LocalMapNames ShortNames(const std::vector<v1::LocalMap>& local_maps);

// Returns the agent's local maps by their ascending numbers: "alpha/1 to alpha/7, alpha/9".
std::string DescribeNumbers(const std::string& agent, const std::vector<uint32_t>& numbers);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_LOCAL_MAP_NAMES_H_
