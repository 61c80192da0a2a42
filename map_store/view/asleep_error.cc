#include "map_store/view/asleep_error.h"

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

constexpr char kAsleepPayload[] = "corbslam.map_store/asleep";

}  // namespace

absl::Status AsleepError(absl::string_view mission) {
  absl::Status error = absl::UnavailableError(
      absl::StrCat("mission ", mission, " was asleep, and is being read from the disk: try again"));
  error.SetPayload(kAsleepPayload, absl::Cord(mission));
  return error;
}

std::optional<std::string> AsleepMission(const absl::Status& status) {
  if (!absl::IsUnavailable(status)) return std::nullopt;
  const auto mission = status.GetPayload(kAsleepPayload);
  if (!mission.has_value()) return std::nullopt;
  return std::string(*mission);
}

}  // namespace corbslam::map_store
