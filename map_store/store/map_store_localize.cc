#include "map_store/process/fusion_executor.h"
#include "map_store/process/mission.h"
#include "map_store/store/map_store.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::StatusOr<LocalizeAnswer> MapStore::Localize(absl::string_view mission_name,
                                                  const LocalizeQuery& query,
                                                  const std::function<bool()>& goes_on) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  if (executor_->worker() == nullptr) {
    return absl::UnavailableError("this store has no fusion worker, which looks pictures up");
  }
  return mission->Localize(*executor_->worker(), query, goes_on);
}

}  // namespace corbslam::map_store
