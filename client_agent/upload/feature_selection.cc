#include "client_agent/upload/feature_selection.h"

#include <algorithm>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMostFeatures = 20'000;

std::vector<bool> ChooseFeatures(const Keyframe& keyframe, size_t up_to) {
  const size_t count = keyframe.points.size();
  std::vector<bool> chosen(count);
  size_t mapped = 0;
  for (size_t i = 0; i < count; ++i) {
    chosen[i] = keyframe.points[i].IsValid();
    mapped += chosen[i];
  }
  const size_t others = count - mapped;
  const size_t wanted = std::min(others, up_to - std::min(up_to, mapped));
  // Takes the k-th of the others when k * wanted / others passes a whole number.
  size_t passed = 0;
  for (size_t i = 0; i < count; ++i) {
    if (keyframe.points[i].IsValid()) continue;
    chosen[i] = (passed + 1) * wanted / others > passed * wanted / others;
    ++passed;
  }
  return chosen;
}

}  // namespace

absl::StatusOr<FeatureSelection> ParseFeatureSelection(absl::string_view text) {
  if (text == "all") return FeatureSelection();
  if (text == "mapped") return FeatureSelection{0};
  size_t number = 0;
  if (absl::SimpleAtoi(text, &number) && number >= 1 && number <= kMostFeatures) {
    return FeatureSelection{number};
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "features=", text, ": must be all, mapped, or a number from 1 to ", kMostFeatures));
}

SelectedFeatures SelectFeatures(const Keyframe& keyframe, const FeatureSelection& selection) {
  const size_t count = keyframe.points.size();
  if (selection.IsAll() || *selection.at_least_mapped_and_up_to >= count) {
    return {keyframe.payload, {}};
  }
  const std::vector<bool> chosen = ChooseFeatures(keyframe, *selection.at_least_mapped_and_up_to);
  const Features& all = keyframe.payload->features;
  SelectedFeatures selected;
  selected.numbers.assign(count, kLeftOut);
  Features features;
  for (size_t i = 0; i < count; ++i) {
    if (!chosen[i]) continue;
    selected.numbers[i] = static_cast<uint32_t>(features.keypoints.size());
    features.keypoints.push_back(all.keypoints[i]);
    features.descriptors.push_back(all.descriptors[i]);
  }
  selected.payload = WithFeatures(*keyframe.payload, std::move(features));
  return selected;
}

}  // namespace corbslam::client_agent
