// Tells a mission from earlier and later ones of its name.
#ifndef CORBSLAM_MAP_STORE_STATE_MISSION_UID_H_
#define CORBSLAM_MAP_STORE_STATE_MISSION_UID_H_

#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::map_store {

// Draws the uid of a mission that is made under this name: 32 hexadecimal digits that no other
// mission has. The last eight check the others and the name.
std::string DrawMissionUid(absl::string_view name);
// Returns whether the text looks like a uid.
bool IsMissionUid(absl::string_view text);
// Returns whether it was drawn for this name: nobody makes up one that was not, or takes another
// mission's.
bool IsUidOf(absl::string_view name, absl::string_view uid);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_MISSION_UID_H_
