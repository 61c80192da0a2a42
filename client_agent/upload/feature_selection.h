// Chooses which features of a keyframe go up to the map store.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_FEATURE_SELECTION_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_FEATURE_SELECTION_H_

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/map/keyframe.h"

namespace corbslam::client_agent {

// Which of a keyframe's features are told to the store.
struct FeatureSelection {
  // Features that see a map point when the keyframe goes up are told, and so many of the others
  // that there are this many together; 0: no others. Nullopt: all are told.
  std::optional<size_t> at_least_mapped_and_up_to;

  bool IsAll() const { return !at_least_mapped_and_up_to.has_value(); }
};

// Reads "all", "mapped" or a number, 1 to 20,000; else INVALID_ARGUMENT.
absl::StatusOr<FeatureSelection> ParseFeatureSelection(absl::string_view text);

inline constexpr uint32_t kLeftOut = std::numeric_limits<uint32_t>::max();

// The features of a keyframe that go up.
struct SelectedFeatures {
  std::shared_ptr<const KeyframePayload> payload;
  // For each keypoint of the keyframe its number in the payload, or kLeftOut. Empty: nothing is
  // left out, and the numbers are the same.
  std::vector<uint32_t> numbers;
};

// Keeps the order of the features. Those that see no map point are taken evenly from their order,
// and so from all scales.
SelectedFeatures SelectFeatures(const Keyframe& keyframe, const FeatureSelection& selection);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_FEATURE_SELECTION_H_
