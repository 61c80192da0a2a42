#include "client_agent/upload/feature_selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kMap{1};

// Returns a keyframe with a hundred keypoints, each with its number as its place; every fifth sees
// a point.
Keyframe MakeKeyframe() {
  Features features;
  features.keypoints.resize(100);
  features.descriptors.resize(100);
  for (uint32_t i = 0; i < 100; ++i) {
    features.keypoints[i].x_px = static_cast<float>(i);
    features.descriptors[i].words[0] = i;
  }
  Keyframe keyframe;
  keyframe.payload =
      MakeKeyframePayload({kMap, 3}, 7, 0, std::make_shared<const Camera>(), std::move(features));
  keyframe.points.resize(100);
  for (uint32_t i = 0; i < 100; i += 5) keyframe.points[i] = {kMap, i};
  return keyframe;
}

size_t CountMapped(const Keyframe& keyframe, const SelectedFeatures& selected) {
  size_t mapped = 0;
  for (size_t i = 0; i < selected.numbers.size(); ++i) {
    mapped += selected.numbers[i] != kLeftOut && keyframe.points[i].IsValid();
  }
  return mapped;
}

TEST(SelectFeaturesTest, AllIsThePayloadItself) {
  const Keyframe keyframe = MakeKeyframe();
  for (const auto& selection : {FeatureSelection(), FeatureSelection{100}, FeatureSelection{500}}) {
    const SelectedFeatures selected = SelectFeatures(keyframe, selection);
    EXPECT_EQ(selected.payload, keyframe.payload);
    EXPECT_TRUE(selected.numbers.empty());
  }
}

TEST(SelectFeaturesTest, WhatSeesAPointAlwaysGoes) {
  const Keyframe keyframe = MakeKeyframe();
  for (const size_t up_to : {0u, 1u, 20u, 21u, 50u, 99u}) {
    const SelectedFeatures selected = SelectFeatures(keyframe, {up_to});
    EXPECT_EQ(CountMapped(keyframe, selected), 20u) << up_to;
    EXPECT_EQ(selected.payload->features.keypoints.size(), std::max<size_t>(up_to, 20)) << up_to;
    EXPECT_EQ(selected.payload->features.descriptors.size(),
              selected.payload->features.keypoints.size());
    EXPECT_EQ(selected.payload->id, (KeyframeId{kMap, 3}));
    EXPECT_EQ(selected.payload->timestamp_ns, 7);
  }
}

TEST(SelectFeaturesTest, NumbersLeadToTheSameFeatures) {
  const Keyframe keyframe = MakeKeyframe();
  const SelectedFeatures selected = SelectFeatures(keyframe, {60});
  for (uint32_t i = 0; i < 100; ++i) {
    if (selected.numbers[i] == kLeftOut) continue;
    const Features& sent = selected.payload->features;
    EXPECT_EQ(sent.keypoints[selected.numbers[i]], keyframe.keypoints()[i]);
    EXPECT_EQ(sent.descriptors[selected.numbers[i]], keyframe.descriptors()[i]);
  }
}

TEST(SelectFeaturesTest, TheOthersAreTakenEvenly) {
  const Keyframe keyframe = MakeKeyframe();
  const SelectedFeatures selected = SelectFeatures(keyframe, {60});
  for (const size_t half : {0u, 50u}) {
    const auto begin = selected.numbers.begin() + static_cast<ptrdiff_t>(half);
    EXPECT_EQ(50 - std::count(begin, begin + 50, kLeftOut), 30);
  }
}

TEST(FeatureSelectionTest, IsWhatItsWordSays) {
  const std::pair<absl::string_view, std::optional<size_t>> kWords[] = {
      {"all", std::nullopt}, {"mapped", 0}, {"1", 1}, {"1200", 1200}, {"20000", 20000}};
  for (const auto& [text, up_to] : kWords) {
    const auto selection = ParseFeatureSelection(text);
    ASSERT_TRUE(selection.ok()) << selection.status();
    EXPECT_EQ(selection->at_least_mapped_and_up_to, up_to) << text;
  }
  for (const absl::string_view text : {"", "none", "0", "-1", "20001", "1.5", "12x", "ALL"}) {
    EXPECT_EQ(ParseFeatureSelection(text).status().code(), absl::StatusCode::kInvalidArgument)
        << text;
  }
}

}  // namespace
}  // namespace corbslam::client_agent
