#include "slam/util/ids.h"

#include "absl/strings/str_cat.h"

namespace corbslam {

std::string ToString(LocalMapId id) { return absl::StrCat(absl::Hex(id.value, absl::kZeroPad16)); }

std::string ToString(KeyframeId id) { return absl::StrCat(ToString(id.local_map), ":", id.index); }

std::string ToString(MapPointId id) { return absl::StrCat(ToString(id.local_map), ":", id.index); }

}  // namespace corbslam
