#include "slam/matching/word_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>

namespace corbslam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

Descriptor RandomDescriptor(std::mt19937_64& random) {
  Descriptor descriptor;
  for (uint64_t& word : descriptor.words) word = random();
  return descriptor;
}

Descriptor FlipBits(Descriptor descriptor, int count) {
  for (int i = 0; i < count; ++i) descriptor.words[0] ^= uint64_t{1} << i;
  return descriptor;
}

Keyframe MakeKeyframe(uint32_t index, const std::vector<Descriptor>& descriptors,
                      const std::vector<float>& angles_rad, bool with_points = true) {
  Features features;
  features.descriptors = descriptors;
  for (const float angle_rad : angles_rad) {
    features.keypoints.push_back({.x_px = 10, .y_px = 10, .angle_rad = angle_rad});
  }
  auto camera = std::make_shared<Camera>(Camera{
      .fx_px = 100, .fy_px = 100, .cx_px = 50, .cy_px = 50, .width_px = 100, .height_px = 100});
  Keyframe keyframe;
  keyframe.payload = MakeKeyframePayload({{1}, index}, 0, 0, camera, std::move(features));
  keyframe.points.resize(descriptors.size());
  if (!with_points) return keyframe;
  for (uint32_t i = 0; i < descriptors.size(); ++i) keyframe.points[i] = {{1}, i};
  return keyframe;
}

std::shared_ptr<const Words> AllUnderOneNode(uint32_t node, size_t count) {
  auto words = std::make_shared<Words>();
  words->direct_index.push_back({node, {}});
  for (uint32_t i = 0; i < count; ++i) words->direct_index[0].features.push_back(i);
  return words;
}

class WordMatchingTest : public ::testing::Test {
 protected:
  WordMatchingTest() {
    for (int i = 0; i < 3; ++i) descriptors_.push_back(RandomDescriptor(random_));
  }
  std::mt19937_64 random_{7};
  std::vector<Descriptor> descriptors_;
};

TEST_F(WordMatchingTest, FindsTheSameDescriptorsInAnotherOrder) {
  const Keyframe a = MakeKeyframe(0, descriptors_, {0, 0, 0});
  const Keyframe b =
      MakeKeyframe(1, {FlipBits(descriptors_[2], 20), descriptors_[0], descriptors_[1]}, {0, 0, 0});
  EXPECT_THAT(MatchByWords(a, b), ElementsAre(Pair(0, 1), Pair(1, 2), Pair(2, 0)));
}

TEST_F(WordMatchingTest, RefusesBeyondTheDistance) {
  const Keyframe a = MakeKeyframe(0, {descriptors_[0]}, {0});
  const Keyframe near = MakeKeyframe(1, {FlipBits(descriptors_[0], 50)}, {0});
  const Keyframe far = MakeKeyframe(1, {FlipBits(descriptors_[0], 51)}, {0});
  EXPECT_THAT(MatchByWords(a, near), ElementsAre(Pair(0, 0)));
  EXPECT_THAT(MatchByWords(a, far), IsEmpty());
}

TEST_F(WordMatchingTest, RefusesAmbiguousOnes) {
  const Keyframe a = MakeKeyframe(0, {descriptors_[0]}, {0});
  const Keyframe b =
      MakeKeyframe(1, {FlipBits(descriptors_[0], 20), FlipBits(descriptors_[0], 24)}, {0, 0});
  EXPECT_THAT(MatchByWords(a, b), IsEmpty());
}

TEST_F(WordMatchingTest, AKeypointIsMatchedOnceByTheNearest) {
  const Keyframe a =
      MakeKeyframe(0, {FlipBits(descriptors_[0], 9), FlipBits(descriptors_[0], 3)}, {0, 0});
  const Keyframe b = MakeKeyframe(1, {descriptors_[0]}, {0});
  EXPECT_THAT(MatchByWords(a, b), ElementsAre(Pair(1, 0)));
}

TEST_F(WordMatchingTest, ComparesOnlyWithinANode) {
  Keyframe a = MakeKeyframe(0, descriptors_, {0, 0, 0});
  Keyframe b = MakeKeyframe(1, descriptors_, {0, 0, 0});
  a.words = AllUnderOneNode(4, 3);
  b.words = AllUnderOneNode(5, 3);
  EXPECT_THAT(MatchByWords(a, b), IsEmpty());
  b.words = AllUnderOneNode(4, 3);
  EXPECT_EQ(MatchByWords(a, b).size(), 3u);
}

TEST_F(WordMatchingTest, NeedsPointsOnlyWhereAsked) {
  const Keyframe a = MakeKeyframe(0, descriptors_, {0, 0, 0}, /*with_points=*/false);
  const Keyframe b = MakeKeyframe(1, descriptors_, {0, 0, 0});
  EXPECT_THAT(MatchByWords(a, b), IsEmpty());
  EXPECT_EQ(MatchByWords(a, b, {.need_points_a = false}).size(), 3u);
  EXPECT_THAT(MatchByWords(b, a, {.need_points_a = false}), IsEmpty());
}

TEST_F(WordMatchingTest, DropsWhatIsTurnedAnotherWay) {
  std::vector<Descriptor> many;
  std::vector<float> angles_a(40, 0.05f);
  std::vector<float> angles_b(40, 1.05f);
  for (int i = 0; i < 40; ++i) many.push_back(RandomDescriptor(random_));
  angles_b[7] = -2.0f;
  const Keyframe a = MakeKeyframe(0, many, angles_a);
  const Keyframe b = MakeKeyframe(1, many, angles_b);
  EXPECT_EQ(MatchByWords(a, b).size(), 39u);
  EXPECT_EQ(MatchByWords(a, b, {.check_orientation = false}).size(), 40u);
}

TEST_F(WordMatchingTest, SurvivesAnIndexThatNamesMissingKeypoints) {
  Keyframe a = MakeKeyframe(0, descriptors_, {0, 0, 0});
  Keyframe b = MakeKeyframe(1, descriptors_, {0, 0, 0});
  a.words = AllUnderOneNode(4, 9);
  b.words = AllUnderOneNode(4, 9);
  EXPECT_EQ(MatchByWords(a, b).size(), 3u);
}

}  // namespace
}  // namespace corbslam
