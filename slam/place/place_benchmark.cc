// Loading a vocabulary, making words and asking the keyframe database. CORBSLAM_VOCABULARY names
// the shipped vocabulary; the one of a million words is synthetic.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "slam/place/keyframe_database.h"
#include "slam/vocabulary/vocabulary.h"
#include "slam/vocabulary/vocabulary_file.h"

namespace corbslam {
namespace {

constexpr size_t kFeatures = 2000;

std::vector<Descriptor> RandomDescriptors(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (uint64_t& word : descriptor.words) word = random();
  }
  return descriptors;
}

// Complete: 10 children a node.
VocabularyTree CompleteTree(uint32_t levels) {
  VocabularyTree tree;
  tree.branching = 10;
  tree.levels = levels;
  tree.direct_level = 2;
  uint32_t inner = 0;
  uint32_t width = 1;
  for (uint32_t level = 0; level < levels; ++level, width *= 10) inner += width;
  const uint32_t nodes = inner + width;
  for (uint32_t node = 0; node <= nodes; ++node) {
    tree.first_child.push_back(node < inner ? 1 + 10 * node : nodes);
  }
  tree.descriptors = RandomDescriptors(nodes, 1);
  tree.weights.assign(nodes, 1.0f);
  return tree;
}

// Removed when the program ends.
const std::string& MillionWordsPath() {
  static const std::string* const path = [] {
    auto* const made =
        new std::string(std::filesystem::temp_directory_path() / "corbslam_million_words.voc");
    if (!WriteVocabulary(CompleteTree(6), *made).ok()) made->clear();
    std::atexit([] { std::remove(MillionWordsPath().c_str()); });
    return made;
  }();
  return *path;
}

std::string PathOf(const benchmark::State& state) {
  if (state.range(0) == 1) return MillionWordsPath();
  const char* const shipped = std::getenv("CORBSLAM_VOCABULARY");
  return shipped == nullptr ? "" : shipped;
}

void LoadVocabulary(benchmark::State& state) {
  const std::string path = PathOf(state);
  for ([[maybe_unused]] auto _ : state) {
    auto vocabulary = Vocabulary::Load(path);
    if (!vocabulary.ok()) return state.SkipWithError("set CORBSLAM_VOCABULARY");
    benchmark::DoNotOptimize(vocabulary);
  }
}

void TransformDescriptors(benchmark::State& state) {
  const auto vocabulary = Vocabulary::Load(PathOf(state));
  if (!vocabulary.ok()) return state.SkipWithError("set CORBSLAM_VOCABULARY");
  // New descriptors each time, so that the tree is not in the cache already.
  std::vector<std::vector<Descriptor>> pictures;
  for (uint64_t i = 0; i < 50; ++i) pictures.push_back(RandomDescriptors(kFeatures, 100 + i));
  size_t next = 0;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize((*vocabulary)->Transform(pictures[next++ % pictures.size()]));
  }
}

void QueryDatabase(benchmark::State& state) {
  const auto vocabulary = Vocabulary::FromTree(CompleteTree(5)).value();
  KeyframeDatabase database;
  for (uint32_t i = 0; i < state.range(0); ++i) {
    database.Add({LocalMapId{1}, i},
                 std::make_shared<Words>(vocabulary->Transform(RandomDescriptors(kFeatures, i))));
  }
  const BagOfWords query = vocabulary->Transform(RandomDescriptors(kFeatures, 7)).bag;
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(database.Query(query));
}

// 0: the shipped one, 1: a million words.
BENCHMARK(LoadVocabulary)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(TransformDescriptors)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(QueryDatabase)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
