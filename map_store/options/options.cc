#include "map_store/options/options.h"

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

absl::Status CheckPositive(absl::string_view field, double value) {
  if (value > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(field, " is ", value, ", must be above 0"));
}

}  // namespace

absl::Status MapStoreOptions::Validate() const {
  absl::Status status;
  status.Update(CheckPositive("min_shared_words", min_shared_words));
  status.Update(CheckPositive("max_candidate_groups", static_cast<double>(max_candidate_groups)));
  status.Update(CheckPositive("neighbourhood", neighbourhood));
  status.Update(CheckPositive("min_shared_landmarks", min_shared_landmarks));
  status.Update(CheckPositive("loop_residual_px", loop_residual_px));
  status.Update(CheckPositive("weld_every", static_cast<double>(weld_every)));
  status.Update(CheckPositive("weld_share", weld_share));
  status.Update(CheckPositive("adjust_share", adjust_share));
  status.Update(CheckPositive("adjust_min_keyframes", static_cast<double>(adjust_min_keyframes)));
  status.Update(CheckPositive("adjust_iterations", adjust_iterations));
  status.Update(CheckPositive("last_adjust_iterations", last_adjust_iterations));
  status.Update(CheckPositive("local_motion_px", local_motion_px));
  if (!(cull_share >= 0 && cull_share <= 1)) {
    status.Update(
        absl::InvalidArgumentError(absl::StrCat("cull_share is ", cull_share, ", must be 0 to 1")));
  }
  if (!(retire_share > 0 && retire_share <= 1)) {
    status.Update(absl::InvalidArgumentError(
        absl::StrCat("retire_share is ", retire_share, ", must be above 0 and at most 1")));
  }
  status.Update(CheckPositive("adjust_threads", adjust_threads));
  status.Update(CheckPositive("fusion_threads", fusion_threads));
  status.Update(CheckPositive("max_attempts", max_attempts));
  status.Update(CheckPositive("retry_ms", retry_ms));
  status.Update(CheckPositive("max_page_size", static_cast<double>(max_page_size)));
  for (const auto& [field, limit] : std::initializer_list<std::pair<absl::string_view, uint64_t>>{
           {"max_missions", max_missions},
           {"max_missions_asleep", max_missions_asleep},
           {"max_agents_per_mission", max_agents_per_mission},
           {"max_local_maps_per_mission", max_local_maps_per_mission},
           {"max_keypoints_per_keyframe", max_keypoints_per_keyframe},
           {"max_keyframe_bytes", max_keyframe_bytes},
           {"max_cameras_per_local_map", max_cameras_per_local_map},
           {"max_items_per_batch", max_items_per_batch},
           {"max_frames_per_batch", max_frames_per_batch},
           {"max_pair_steps_per_batch", max_pair_steps_per_batch},
           {"max_parked_references", max_parked_references},
           {"max_localised_frames_per_agent", max_localised_frames_per_agent},
           {"max_bytes_per_agent", max_bytes_per_agent},
           {"max_bytes_per_mission", max_bytes_per_mission},
           {"max_backup_bytes", max_backup_bytes}}) {
    status.Update(CheckPositive(field, static_cast<double>(limit)));
  }
  status.Update(CheckPositive("max_parked_s", max_parked_s));
  for (const auto& [field, seconds] : std::initializer_list<std::pair<absl::string_view, double>>{
           {"sleep_after_s", sleep_after_s}, {"end_s", end_s}}) {
    if (seconds >= 0) continue;
    status.Update(
        absl::InvalidArgumentError(absl::StrCat(field, " is ", seconds, ", must be at least 0")));
  }
  if (min_shared_words_ratio < 0 || min_shared_words_ratio > 1) {
    status.Update(absl::InvalidArgumentError(
        absl::StrCat("min_shared_words_ratio is ", min_shared_words_ratio, ", must be 0 to 1")));
  }
  return status;
}

MapStoreOptions MapStoreOptions::WithoutBatchLimits() {
  constexpr size_t kAny = std::numeric_limits<size_t>::max();
  MapStoreOptions options;
  options.max_keypoints_per_keyframe = kAny;
  options.max_keyframe_bytes = kAny;
  options.max_cameras_per_local_map = kAny;
  options.max_items_per_batch = kAny;
  options.max_frames_per_batch = kAny;
  options.max_pair_steps_per_batch = kAny;
  options.max_parked_references = kAny;
  return options;
}

}  // namespace corbslam::map_store
