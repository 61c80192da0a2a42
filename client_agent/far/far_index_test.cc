#include "client_agent/far/far_index.h"

#include <gtest/gtest.h>

#include "client_agent/far/far_choice.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kFirst{11};
constexpr LocalMapId kSecond{12};
using Told = std::map<KeyframeId, std::vector<MapPointId>>;

// A picture with three words of its own, and one that all have.
std::shared_ptr<const Words> WordsOf(uint32_t place) {
  auto words = std::make_shared<Words>();
  words->bag = {{0, 0.1F}, {10 * place + 1, 0.3F}, {10 * place + 2, 0.3F}, {10 * place + 3, 0.3F}};
  return words;
}

// Keyframes a metre apart along x.
std::vector<FarPlace> Row(LocalMapId local_map, int count, double begin_m = 0) {
  std::vector<FarPlace> places;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<uint32_t>(i);
    places.push_back({{local_map, index}, {begin_m + i, 0, 0}, WordsOf(index + 1)});
  }
  return places;
}

TEST(FarIndexTest, TheNearestComeFirstAndNoneFromBeyondTheRadius) {
  FarIndex index(100);
  index.Add(Row(kFirst, 20));
  index.Add(Row(kSecond, 20, 100));
  const std::vector<Eigen::Vector3d> here = {{10.2, 0, 0}};
  const auto near = index.Nearest(here, 2.5, 100);
  ASSERT_EQ(near.size(), 5u);
  EXPECT_EQ(near[0].id, (KeyframeId{kFirst, 10}));
  EXPECT_EQ(near[1].id, (KeyframeId{kFirst, 11}));
  EXPECT_EQ(index.Nearest(here, 2.5, 3).size(), 3u);
  const std::vector<Eigen::Vector3d> both = {{-1, 0, 0}, {99.5, 0, 0}};
  EXPECT_EQ(index.Nearest(both, 5, 1).front().id, (KeyframeId{kSecond, 0}));
  EXPECT_TRUE(index.Nearest({}, 1e9, 10).empty());
}

TEST(FarIndexTest, APlaceIsRecognisedByWhatItLooksLike) {
  FarIndex index(100);
  index.Add(Row(kFirst, 20));
  EXPECT_EQ(index.bags(), 20 / FarIndex::kFirstStride);
  const auto place = index.Recognise(WordsOf(9)->bag, 0.5);
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(*place, Eigen::Vector3d(8, 0, 0));
  EXPECT_FALSE(index.Recognise(WordsOf(1000)->bag, 0.5).has_value());
}

TEST(FarIndexTest, WhatPlacesLookLikeIsBoundedAndSpreadOverAllOfThem) {
  FarIndex index(16);
  for (uint64_t part = 0; part < 40; ++part) {
    index.Add(Row({100 + part}, 20, 20.0 * static_cast<double>(part)));
    EXPECT_LE(index.bags(), 16u);
  }
  EXPECT_GE(index.bags(), 8u);
  EXPECT_EQ(index.keyframes(), 800u);
}

TEST(FarIndexTest, AForgottenLocalMapIsNeitherNearNorRecognised) {
  FarIndex index(100);
  index.Add(Row(kFirst, 20));
  index.Remove(kFirst);
  EXPECT_EQ(index.keyframes(), 0u);
  EXPECT_EQ(index.bags(), 0u);
  EXPECT_FALSE(index.Recognise(WordsOf(9)->bag, 0.1).has_value());
}

class FarChooserTest : public ::testing::Test {
 protected:
  FarChooserTest() { index_.Add(Row(kFirst, 1000)); }

  FarChoice At(double x, bool anew = false, std::optional<Eigen::Vector3d> recognised = {}) {
    const FarChoice choice = chooser_.Choose(index_, told_, {x, 0, 0}, recognised, anew);
    for (const auto& [local_map, ids] : choice.bring) {
      for (const KeyframeId id : ids) told_[id] = {};
    }
    for (const KeyframeId id : choice.take_out) told_.erase(id);
    return choice;
  }

  FarIndex index_{1000};
  FarChooser chooser_{FarReach{.radius = 20, .max_keyframes = 60}};
  Told told_;
};

TEST_F(FarChooserTest, WhatIsNearComesAndGoesAsTheRobotGoesOn) {
  EXPECT_EQ(At(100).bring.at(kFirst).size(), 41u);
  EXPECT_TRUE(At(101).IsEmpty()) << "a choice holds for some way";
  const FarChoice next = At(110);
  EXPECT_EQ(next.bring.at(kFirst).size(), 10u);
  EXPECT_EQ(next.take_out.size(), 10u);
  EXPECT_EQ(told_.size(), 41u);
}

TEST_F(FarChooserTest, NoMoreComeThanFit) {
  chooser_.SetMaxKeyframes(11);
  At(100);
  EXPECT_EQ(told_.size(), 11u);
  EXPECT_EQ(told_.begin()->first.index, 95u) << "the nearest";
  EXPECT_TRUE(At(100.5).IsEmpty());
  EXPECT_FALSE(At(101).IsEmpty()) << "the reach is short, so that the next choice is soon";
  EXPECT_EQ(told_.size(), 11u);
}

TEST_F(FarChooserTest, APlaceThatWasRecognisedComesThoughItIsFar) {
  At(100);
  At(100, /*anew=*/true, Eigen::Vector3d(500, 0, 0));
  EXPECT_TRUE(told_.contains({kFirst, 500}));
  EXPECT_TRUE(told_.contains({kFirst, 100}));
  EXPECT_EQ(told_.size(), 60u);
}

}  // namespace
}  // namespace corbslam::client_agent
