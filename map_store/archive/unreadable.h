// What is said of bytes that are not what an Encode function made.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_UNREADABLE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_UNREADABLE_H_

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

inline absl::Status Unreadable(absl::string_view what) {
  return absl::DataLossError(absl::StrCat(what, " can't be read: its bytes are damaged"));
}
inline absl::Status DifferentCount(KeyframeId id) {
  return Unreadable(absl::StrCat("the number of keypoints of keyframe ", ToString(id)));
}

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_UNREADABLE_H_
