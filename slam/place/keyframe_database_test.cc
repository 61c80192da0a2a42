#include "slam/place/keyframe_database.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "slam/map/map.h"
#include "slam/place/candidate_groups.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam {
namespace {

template <typename T, typename V>
QueryOptions With(T QueryOptions::*option, V value) {
  QueryOptions options;
  options.*option = static_cast<T>(value);
  return options;
}

KeyframeId Id(uint32_t index) { return {LocalMapId{7}, index}; }

std::shared_ptr<const Words> RandomWords(std::mt19937_64& random) {
  std::set<uint32_t> chosen;
  while (chosen.size() < 30) chosen.insert(static_cast<uint32_t>(random() % 200));
  auto words = std::make_shared<Words>();
  for (const uint32_t word : chosen) words->bag.push_back({word, 1.0f / 30});
  return words;
}

using Content = std::map<KeyframeId, std::shared_ptr<const Words>>;

int CountShared(const BagOfWords& a, const BagOfWords& b) {
  int shared = 0;
  for (const WordWeight& word : a) {
    shared += std::any_of(b.begin(), b.end(),
                          [&word](const WordWeight& other) { return other.word == word.word; });
  }
  return shared;
}

void ExpectBruteForce(const KeyframeDatabase& database, const Content& content,
                      const BagOfWords& query) {
  QueryOptions options;
  options.min_shared_fraction_of_best = 0;
  const std::vector<PlaceCandidate> found = database.Query(query, options);
  size_t expected = 0;
  for (const auto& [id, words] : content) expected += CountShared(query, words->bag) > 0;
  ASSERT_EQ(found.size(), expected);
  for (size_t i = 0; i < found.size(); ++i) {
    const BagOfWords& bag = content.at(found[i].id)->bag;
    EXPECT_NEAR(found[i].score, Similarity(query, bag), 1e-6);
    EXPECT_EQ(found[i].shared_words, CountShared(query, bag));
    if (i == 0) continue;
    EXPECT_TRUE(found[i - 1].score > found[i].score ||
                (found[i - 1].score == found[i].score && found[i - 1].id < found[i].id));
  }
}

TEST(KeyframeDatabase, EqualsBruteForceThroughAddAndRemove) {
  std::mt19937_64 random(1);
  KeyframeDatabase database;
  Content content;
  for (int step = 0; step < 300; ++step) {
    const KeyframeId id = Id(static_cast<uint32_t>(random() % 60));
    if (random() % 3 == 0) {
      EXPECT_EQ(database.Remove(id), content.erase(id) == 1);
    } else {
      content[id] = RandomWords(random);
      database.Add(id, content[id]);
    }
    ASSERT_EQ(database.size(), content.size());
    if (step % 20 == 0) ExpectBruteForce(database, content, RandomWords(random)->bag);
  }
}

// A query with few postings in a large map goes another way than one with many.
TEST(KeyframeDatabase, AQueryThatTouchesLittleOfALargeMapEqualsBruteForce) {
  KeyframeDatabase database;
  Content content;
  for (uint32_t i = 0; i < 2000; ++i) {
    // Four keyframes have word 1000 + i / 4.
    const BagOfWords bag = {{1000 + i / 4, 0.5f}, {5000 + i, 0.5f}};
    content[Id(i)] = std::make_shared<Words>(Words{bag, {}});
    database.Add(Id(i), content[Id(i)]);
  }
  for (uint32_t i = 0; i < 2000; i += 3) {
    ASSERT_TRUE(database.Remove(Id(i)));
    content.erase(Id(i));
  }
  const BagOfWords query = {{1025, 0.3f}, {1026, 0.3f}, {5105, 0.3f}, {9999, 0.1f}};
  EXPECT_EQ(database.CountPostings(query), 6u);  // Keyframes 100, 101, 103; 104, 106, 107; none.
  ExpectBruteForce(database, content, query);
  EXPECT_EQ(database.CountPostings({}), 0u);
}

TEST(KeyframeDatabase, OptionsNarrowTheResult) {
  KeyframeDatabase database;
  const auto add = [&database](uint32_t index, BagOfWords bag) {
    database.Add(Id(index), std::make_shared<Words>(Words{std::move(bag), {}}));
  };
  add(1, {{1, 0.2f}, {2, 0.2f}, {3, 0.2f}, {4, 0.2f}, {5, 0.2f}});
  add(2, {{1, 0.25f}, {2, 0.25f}, {3, 0.25f}, {4, 0.25f}});
  add(3, {{1, 1.0f}});
  const BagOfWords query = {{1, 0.2f}, {2, 0.2f}, {3, 0.2f}, {4, 0.2f}, {5, 0.2f}};
  // 0.8 of the five words that keyframe 1 shares are four.
  EXPECT_EQ(database.Query(query).size(), 2u);
  EXPECT_EQ(database.Query(query, With(&QueryOptions::max_results, 1)).front().id, Id(1));
  EXPECT_EQ(database.Query(query, With(&QueryOptions::min_score, 0.9)).size(), 1u);
  EXPECT_EQ(database.Query(query, With(&QueryOptions::min_shared_words, 5)).size(), 1u);
  EXPECT_EQ(database.Query(query, With(&QueryOptions::min_shared_fraction_of_best, 0)).size(), 3u);
  // Keyframes that are not admitted set no standard for the others.
  const auto not_1_or_2 = [](KeyframeId id) { return id.index > 2; };
  EXPECT_EQ(database.Query(query, With(&QueryOptions::admit, not_1_or_2)).front().id, Id(3));
  EXPECT_TRUE(database.Query({}).empty());
}

// A chain of keyframes; neighbours share a point.
Map Chain(uint32_t count) {
  Map map;
  const auto camera = std::make_shared<Camera>();
  for (uint32_t i = 0; i < count; ++i) {
    Features features;
    features.keypoints.resize(2);
    features.descriptors.resize(2);
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(Id(i), 0, 0, camera, features);
    map.AddKeyframe(std::move(keyframe));
    if (i == 0) continue;
    MapPoint point;
    point.id = {LocalMapId{7}, i};
    map.AddPoint(point);
    map.AddObservation(point.id, Id(i - 1), 1);
    map.AddObservation(point.id, Id(i), 0);
  }
  return map;
}

TEST(GroupByCovisibility, NeighboursOutweighALonelyCandidate) {
  const Map map = Chain(10);
  const std::vector<PlaceCandidate> candidates = {
      {Id(8), 9, 0.5}, {Id(2), 9, 0.4}, {Id(1), 9, 0.3}, {Id(3), 9, 0.2}};
  const std::vector<CandidateGroup> groups = GroupByCovisibility(map, candidates, 3, 0);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].best.id, Id(2));
  EXPECT_NEAR(groups[0].score, 0.9, 1e-9);
  EXPECT_EQ(groups[0].members, (std::vector<KeyframeId>{Id(2), Id(1), Id(3)}));
  EXPECT_EQ(groups[1].best.id, Id(8));
  EXPECT_EQ(GroupByCovisibility(map, candidates, 1).size(), 1u);
  EXPECT_EQ(GroupByCovisibility(map, candidates, 3, 0.75).size(), 1u);
  EXPECT_TRUE(GroupByCovisibility(map, {}, 3).empty());
}

TEST(KeyframeDatabase, WhatItTakesGoesWithItsKeyframes) {
  constexpr uint32_t kKeyframes = 100;
  std::mt19937_64 random(5);
  Content content;
  for (uint32_t i = 0; i < kKeyframes; ++i) content[Id(i)] = RandomWords(random);
  KeyframeDatabase database;
  for (const auto& [id, words] : content) database.Add(id, words);
  const uint64_t full = database.HeapBytes();
  EXPECT_GT(full, kKeyframes * 30 * 12) << "a posting and its position, of each word";
  for (const auto& [id, words] : content) database.Remove(id);
  EXPECT_LT(database.HeapBytes(), full / 4);
  for (const auto& [id, words] : content) database.Add(id, words);
  EXPECT_NEAR(static_cast<double>(database.HeapBytes()), static_cast<double>(full), 1000);
}

}  // namespace
}  // namespace corbslam
