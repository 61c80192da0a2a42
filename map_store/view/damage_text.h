// Says that a mission's journal is damaged.
#ifndef CORBSLAM_MAP_STORE_VIEW_DAMAGE_TEXT_H_
#define CORBSLAM_MAP_STORE_VIEW_DAMAGE_TEXT_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::map_store {

// Returns what is damaged (an error that names the file or the place) and what people can do; empty
// for OK.
std::string SayDamage(absl::string_view mission, const absl::Status& damage);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_DAMAGE_TEXT_H_
