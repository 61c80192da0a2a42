#include "map_store/view/damage_text.h"

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {

std::string SayDamage(absl::string_view mission, const absl::Status& damage) {
  if (damage.ok()) return "";
  return absl::StrCat("mission ", mission, " is damaged, and takes nothing in: ", damage.message(),
                      ". Restore its last backup under another name (corbslam mission restore), "
                      "and delete it (corbslam mission delete). `corbslam journal check` says of "
                      "a stopped store's folder what is damaged");
}

}  // namespace corbslam::map_store
