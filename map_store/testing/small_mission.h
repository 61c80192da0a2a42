// A mission of two robots as its journal has it: a few records of every kind, a few kB.
#ifndef CORBSLAM_MAP_STORE_TESTING_SMALL_MISSION_H_
#define CORBSLAM_MAP_STORE_TESTING_SMALL_MISSION_H_

#include <vector>

#include "map_store/records/journal_records.h"

namespace corbslam::testing {

inline constexpr LocalMapId kSmallMapA{1};  // Agent a's.
inline constexpr LocalMapId kSmallMapB{2};  // Agent b's.

// Returns the features that all keyframes have.
Features MakeSmallFeatures();

// Returns the records in their order. After them both local maps are in one island, at revision 2,
// a point of each is one landmark, and references wait for what never comes.
std::vector<map_store::JournalRecord> MakeSmallMission();

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_SMALL_MISSION_H_
