// Writes what a store answers as text, to be compared.
#ifndef CORBSLAM_MAP_STORE_TESTING_STORE_DUMP_H_
#define CORBSLAM_MAP_STORE_TESTING_STORE_DUMP_H_

#include <string>

#include "map_store/store/map_store.h"

namespace corbslam::testing {

// These return all that look-ups say of a mission's local layer, or of its global layer. The
// mission must exist.
std::string DumpLocal(const std::string& mission, const map_store::MapStore& store);
std::string DumpGlobal(const std::string& mission, const map_store::MapStore& store);
// Returns where fusion has keyframes and points, without revisions and counts.
std::string DumpPlaces(const std::string& mission, const map_store::MapStore& store);

// Returns the first line of both that differs, cut short; empty if they are the same.
std::string FirstDifference(const std::string& a, const std::string& b);

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_STORE_DUMP_H_
