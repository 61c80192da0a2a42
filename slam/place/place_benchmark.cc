// Measures loading a vocabulary, making words, and the keyframe database at size.
// CORBSLAM_VOCABULARY names the shipped vocabulary; the one of a million words is synthetic.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
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

// The tree is complete, with 10 children a node.
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

// The file is removed when the program ends.
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
  // Descriptors are new each time, so that the tree is not in the cache already.
  std::vector<std::vector<Descriptor>> pictures;
  for (uint64_t i = 0; i < 50; ++i) pictures.push_back(RandomDescriptors(kFeatures, 100 + i));
  size_t next = 0;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize((*vocabulary)->Transform(pictures[next++ % pictures.size()]));
  }
}

// Makes bags as real pictures have them. The shipped vocabulary's words follow Zipf and
// Mandelbrot's law, p(rank) ~ (rank + shift)^-exponent: over the 977 pictures of KITTI, TUM and the
// training set a picture has 1,813 of 93,730 words and shares 143 with another one, which is what
// this law gives (docs/lab/2026-11-22-keyframe-database-by-size.md). Evenly drawn words would share
// 35.
class BagMaker {
 public:
  static constexpr uint32_t kVocabulary = 93730;
  static constexpr size_t kWords = 1813;

  BagMaker() {
    std::vector<double> up_to(kVocabulary);
    double sum = 0;
    for (uint32_t word = 0; word < kVocabulary; ++word) {
      up_to[word] = sum += std::pow(word + 1 + kShift, -kExponent);
    }
    uint32_t word = 0;
    for (size_t i = 0; i < word_at_.size(); ++i) {
      const double at = sum * (static_cast<double>(i) + 0.5) / static_cast<double>(word_at_.size());
      while (up_to[word] < at) ++word;
      word_at_[i] = word;
    }
  }

  std::shared_ptr<const Words> Make(uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::vector<uint32_t> drawn;
    while (drawn.size() < kWords) {
      while (drawn.size() < kWords + kWords / 16) {
        drawn.push_back(word_at_[random() % word_at_.size()]);
      }
      std::sort(drawn.begin(), drawn.end());
      drawn.erase(std::unique(drawn.begin(), drawn.end()), drawn.end());
    }
    auto words = std::make_shared<Words>();
    words->bag.reserve(drawn.size());
    const float weight = 1.0f / static_cast<float>(drawn.size());
    for (const uint32_t one : drawn) words->bag.push_back({one, weight});
    return words;
  }

 private:
  static constexpr double kExponent = 0.9;
  static constexpr double kShift = 539;

  // Inverse of the law: the word at each even share of the whole.
  std::vector<uint32_t> word_at_ = std::vector<uint32_t>(1 << 20);
};

const BagMaker& Bags() {
  static const auto* const maker = new BagMaker();
  return *maker;
}

KeyframeId Id(uint32_t index) { return {LocalMapId{1}, index}; }

// Each database is made once. Only the last size is kept, because 100,000 keyframes take 4 GB.
KeyframeDatabase& DatabaseOf(int64_t keyframes) {
  static auto* const made = new std::map<int64_t, KeyframeDatabase>();
  const auto found = made->find(keyframes);
  if (found != made->end()) return found->second;
  made->clear();
  KeyframeDatabase& database = (*made)[keyframes];
  for (uint32_t i = 0; i < keyframes; ++i) database.Add(Id(i), Bags().Make(i));
  return database;
}

// Makes bags of pictures that are not in the database.
std::vector<std::shared_ptr<const Words>> OtherBags() {
  std::vector<std::shared_ptr<const Words>> bags;
  for (uint64_t i = 0; i < 16; ++i) bags.push_back(Bags().Make(1000000 + i));
  return bags;
}

void QueryDatabase(benchmark::State& state) {
  const KeyframeDatabase& database = DatabaseOf(state.range(0));
  const auto bags = OtherBags();
  size_t next = 0;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(database.Query(bags[next++ % bags.size()]->bag));
  }
  double postings = 0;
  for (const auto& words : bags)
    postings += static_cast<double>(database.CountPostings(words->bag));
  postings /= static_cast<double>(bags.size());
  state.counters["postings"] = postings;
  state.counters["postings_per_s"] =
      benchmark::Counter(postings, benchmark::Counter::kIsIterationInvariantRate);
}

// Queries a word that a single keyframe has, so that all of the cost is what the database's size
// adds.
void QueryRareWord(benchmark::State& state) {
  KeyframeDatabase& database = DatabaseOf(state.range(0));
  const KeyframeId rare{LocalMapId{2}, 0};
  const BagOfWords query = {{BagMaker::kVocabulary, 1.0f}};
  database.Add(rare, std::make_shared<Words>(Words{query, {}}));
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(database.Query(query));
  state.counters["postings"] = static_cast<double>(database.CountPostings(query));
  database.Remove(rare);
}

void AddKeyframe(benchmark::State& state) {
  KeyframeDatabase& database = DatabaseOf(state.range(0));
  const auto bags = OtherBags();
  uint32_t next = 0;
  for ([[maybe_unused]] auto _ : state) {
    database.Add({LocalMapId{3}, next}, bags[next % bags.size()]);
    ++next;
  }
  while (next > 0) database.Remove({LocalMapId{3}, --next});
}

// The oldest keyframes go, as if they were culled, and come back afterwards.
void RemoveKeyframe(benchmark::State& state) {
  KeyframeDatabase& database = DatabaseOf(state.range(0));
  uint32_t next = 0;
  for ([[maybe_unused]] auto _ : state) database.Remove(Id(next++));
  while (next > 0) {
    --next;
    database.Add(Id(next), Bags().Make(next));
  }
}

// 0: the shipped one, 1: a million words.
BENCHMARK(LoadVocabulary)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(TransformDescriptors)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

// Benchmarks are registered by the number of keyframes, all of one size before the next.
constexpr int kChanged = 200;
[[maybe_unused]] const bool registered = [] {
  for (const int64_t keyframes : {1000, 10000, 100000}) {
    const auto set_up = [keyframes](const char* name, void (*function)(benchmark::State&)) {
      return benchmark::RegisterBenchmark(name, function)
          ->Arg(keyframes)
          ->Unit(benchmark::kMillisecond);
    };
    set_up("QueryDatabase", QueryDatabase);
    set_up("QueryRareWord", QueryRareWord);
    set_up("AddKeyframe", AddKeyframe)->Iterations(kChanged);
    set_up("RemoveKeyframe", RemoveKeyframe)->Iterations(kChanged);
  }
  return true;
}();

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
