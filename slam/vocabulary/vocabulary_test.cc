#include "slam/vocabulary/vocabulary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include "slam/vocabulary/trainer.h"
#include "slam/vocabulary/vocabulary_file.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

std::vector<Descriptor> RandomDescriptors(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (uint64_t& word : descriptor.words) word = random();
  }
  return descriptors;
}

PictureDescriptors RandomPictures() {
  PictureDescriptors pictures;
  for (uint64_t i = 0; i < 12; ++i) pictures.push_back(RandomDescriptors(100, i));
  return pictures;
}

VocabularyTree SmallTree(int threads = 1) {
  TrainingOptions options;
  options.branching = 5;
  options.levels = 3;
  options.threads = threads;
  return TrainVocabulary(options, RandomPictures()).value();
}

std::string TestPath(const std::string& name) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  return testing::TempDir() + "vocabulary_test_" + test + "_" + name;
}

std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void WriteAll(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

uint32_t NearestLeaf(const VocabularyTree& tree, const Descriptor& descriptor) {
  uint32_t node = 0;
  while (tree.first_child[node] < tree.first_child[node + 1]) {
    uint32_t best = tree.first_child[node];
    for (uint32_t child = best; child < tree.first_child[node + 1]; ++child) {
      if (HammingDistance(descriptor, tree.descriptors[child]) <
          HammingDistance(descriptor, tree.descriptors[best])) {
        best = child;
      }
    }
    node = best;
  }
  return node;
}

TEST(Vocabulary, TransformEqualsBruteForceDescent) {
  const VocabularyTree tree = SmallTree();
  const auto vocabulary = Vocabulary::FromTree(tree).value();
  const std::vector<Descriptor> descriptors = RandomDescriptors(300, 77);
  std::map<uint32_t, double> expected;
  double sum = 0;
  for (const Descriptor& descriptor : descriptors) {
    const uint32_t leaf = NearestLeaf(tree, descriptor);
    expected[leaf] += tree.weights[leaf];
    sum += tree.weights[leaf];
  }

  const Words words = vocabulary->Transform(descriptors);

  std::erase_if(expected, [](const auto& word) { return word.second == 0; });
  ASSERT_EQ(words.bag.size(), expected.size());
  auto word = words.bag.begin();
  for (const auto& [leaf, weight] : expected) {
    EXPECT_EQ(word->word, leaf);
    EXPECT_NEAR(word++->weight, weight / sum, 1e-6);
  }
}

TEST(Vocabulary, DirectIndexHoldsEveryFeatureOnceAtTheMiddleLevel) {
  const VocabularyTree tree = SmallTree();
  const auto vocabulary = Vocabulary::FromTree(tree).value();
  const Words words = vocabulary->Transform(RandomDescriptors(300, 5));
  std::vector<int> seen(300, 0);
  const uint32_t level2 = tree.first_child[1];
  for (size_t i = 0; i < words.direct_index.size(); ++i) {
    const NodeFeatures& group = words.direct_index[i];
    if (i > 0) {
      EXPECT_LT(words.direct_index[i - 1].node, group.node);
    }
    EXPECT_GE(group.node, level2);
    EXPECT_LT(group.node, tree.first_child[level2]);
    for (const uint32_t feature : group.features) ++seen.at(feature);
  }
  EXPECT_THAT(seen, testing::Each(1));
}

TEST(Vocabulary, NoDescriptorsNoWords) {
  const Words words = Vocabulary::FromTree(SmallTree()).value()->Transform({});
  EXPECT_TRUE(words.bag.empty());
  EXPECT_TRUE(words.direct_index.empty());
}

TEST(Similarity, IsOneForItselfSymmetricAndZeroForDisjointBags) {
  const auto vocabulary = Vocabulary::FromTree(SmallTree()).value();
  const BagOfWords a = vocabulary->Transform(RandomDescriptors(200, 1)).bag;
  const BagOfWords b = vocabulary->Transform(RandomDescriptors(200, 2)).bag;
  EXPECT_NEAR(Similarity(a, a), 1, 1e-5);
  EXPECT_EQ(Similarity(a, b), Similarity(b, a));
  EXPECT_GT(Similarity(a, b), 0);
  EXPECT_LT(Similarity(a, b), 1);
  EXPECT_EQ(Similarity({{1, 0.5f}, {3, 0.5f}}, {{2, 0.25f}, {4, 0.75f}}), 0);
  EXPECT_EQ(Similarity({}, a), 0);
}

TEST(Trainer, ThreadsChangeNothingAndSeedsDo) {
  const uint64_t one = ComputeFingerprint(VocabularyTreeView(SmallTree(1)));
  EXPECT_EQ(one, ComputeFingerprint(VocabularyTreeView(SmallTree(3))));
  TrainingOptions options;
  options.branching = 5;
  options.levels = 3;
  options.seed = 2;
  const VocabularyTree other = TrainVocabulary(options, RandomPictures()).value();
  EXPECT_NE(one, ComputeFingerprint(VocabularyTreeView(other)));
}

TEST(Trainer, FindsWellSeparatedClusters) {
  // Eight centres, each seen with at most 10 flipped bits: noise never makes two of them one.
  const std::vector<Descriptor> centres = RandomDescriptors(8, 3);
  PictureDescriptors pictures(4);
  std::mt19937_64 random(9);
  for (size_t i = 0; i < 400; ++i) {
    Descriptor descriptor = centres[i % 8];
    for (int flip = 0; flip < 10; ++flip) {
      const uint64_t bit = random() % 256;
      descriptor.words[bit / 64] ^= uint64_t{1} << (bit % 64);
    }
    pictures[i % 4].push_back(descriptor);
  }
  TrainingOptions options;
  options.branching = 8;
  options.levels = 1;
  options.direct_level = 1;
  const VocabularyTree tree = TrainVocabulary(options, pictures).value();
  int found = 0;
  for (const Descriptor& centre : centres) {
    found += HammingDistance(tree.descriptors[NearestLeaf(tree, centre)], centre) <= 3;
  }
  EXPECT_GE(found, 7);
  // Picture p shows centres p and p + 4 only: ln(4 / 1).
  EXPECT_NEAR(tree.weights[1], std::log(4), 1e-5);
}

TEST(Trainer, RefusesTooLittleAndBadOptions) {
  EXPECT_FALSE(TrainVocabulary({}, {}).ok());
  EXPECT_FALSE(TrainVocabulary({}, {{Descriptor()}, {Descriptor()}}).ok());
  TrainingOptions options;
  options.branching = 1;
  EXPECT_THAT(std::string(options.Validate().message()), HasSubstr("branching is 1"));
}

TEST(VocabularyFile, LoadsWhatWasWritten) {
  const VocabularyTree tree = SmallTree();
  const std::string path = TestPath("a.voc");
  ASSERT_TRUE(WriteVocabulary(tree, path).ok());
  const auto loaded = Vocabulary::Load(path).value();
  const auto made = Vocabulary::FromTree(tree).value();
  EXPECT_TRUE(loaded->Verify().ok());
  EXPECT_EQ(loaded->fingerprint(), made->fingerprint());
  EXPECT_EQ(loaded->words(), made->words());
  const auto descriptors = RandomDescriptors(50, 4);
  EXPECT_EQ(loaded->Transform(descriptors).bag, made->Transform(descriptors).bag);
  const VocabularySummary summary = InspectVocabulary(path).value();
  EXPECT_EQ(summary.words, made->words());
  EXPECT_EQ(summary.bytes, ReadAll(path).size());
  EXPECT_EQ(summary.direct_nodes, 25u);
}

TEST(VocabularyFile, TruncatedFilesAreRefused) {
  const std::string path = TestPath("a.voc");
  ASSERT_TRUE(WriteVocabulary(SmallTree(), path).ok());
  const std::string content = ReadAll(path);
  for (size_t size = 0; size < content.size(); size += size < 80 ? 3 : 197) {
    WriteAll(path, content.substr(0, size));
    const auto loaded = Vocabulary::Load(path);
    ASSERT_EQ(loaded.status().code(), absl::StatusCode::kDataLoss) << size;
    EXPECT_THAT(std::string(loaded.status().message()), HasSubstr(path));
  }
  EXPECT_EQ(Vocabulary::Load(path + ".none").status().code(), absl::StatusCode::kNotFound);
}

TEST(VocabularyFile, FlippedBitsAreFoundAndNeverCrash) {
  const std::string path = TestPath("a.voc");
  ASSERT_TRUE(WriteVocabulary(SmallTree(), path).ok());
  const std::string content = ReadAll(path);
  const auto descriptors = RandomDescriptors(20, 8);
  for (size_t at = 0; at < content.size(); at += at < 64 ? 1 : 43) {
    std::string damaged = content;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
    WriteAll(path, damaged);
    const auto loaded = Vocabulary::Load(path);
    if (!loaded.ok()) continue;
    EXPECT_FALSE((*loaded)->Verify().ok()) << "byte " << at;
    for (const WordWeight& word : (*loaded)->Transform(descriptors).bag) {
      EXPECT_LT(word.word, (*loaded)->nodes());
    }
  }
}

TEST(TextVocabulary, RoundTrip) {
  const VocabularyTree tree = SmallTree();
  const std::string path = TestPath("a.txt");
  ASSERT_TRUE(WriteTextVocabulary(tree, path).ok());
  const VocabularyTree read = ReadTextVocabulary(path).value();
  EXPECT_EQ(ComputeFingerprint(VocabularyTreeView(read)),
            ComputeFingerprint(VocabularyTreeView(tree)));
}

TEST(TextVocabulary, DepthFirstFilesAreReordered) {
  const std::string path = TestPath("a.txt");
  std::string zeros;
  for (int i = 0; i < 31; ++i) zeros += " 0";
  // Node 1 with leaves 2 and 3, then leaf 4.
  WriteAll(path, "2 2 0 0\n0 0 1" + zeros + " 0\n1 1 2" + zeros + " 0.5\n1 1 3" + zeros +
                     " 0.25\n0 1 4" + zeros + " 1.5\n");
  const VocabularyTree tree = ReadTextVocabulary(path).value();
  EXPECT_EQ(tree.first_child, (std::vector<uint32_t>{1, 3, 5, 5, 5, 5}));
  EXPECT_EQ(tree.weights, (std::vector<float>{0, 0, 1.5f, 0.5f, 0.25f}));
  EXPECT_EQ(tree.descriptors[2].words[0], 4u);
  EXPECT_EQ(tree.descriptors[4].words[0], 3u);
}

TEST(TextVocabulary, ErrorsNameFileAndLine) {
  const std::string path = TestPath("a.txt");
  ASSERT_TRUE(WriteTextVocabulary(SmallTree(), path).ok());
  const std::string content = ReadAll(path);
  const auto message = [&](const std::string& text) {
    WriteAll(path, text);
    return std::string(ReadTextVocabulary(path).status().message());
  };
  const size_t second = content.find('\n') + 1;
  EXPECT_THAT(message("1 3 0 0\n"), HasSubstr(path + ":1: does not start with branching"));
  EXPECT_THAT(message("5 3 1 0\n"), HasSubstr(":1: scoring"));
  EXPECT_THAT(message(content.substr(0, second)), HasSubstr(":1: ends before"));
  EXPECT_THAT(message(content.substr(0, second) + "1 0 2\n"), HasSubstr(":2: parent"));
  EXPECT_THAT(message(content.substr(0, second) + "0 1 2 3 256\n"), HasSubstr(":2: byte 2 of 32"));
  EXPECT_THAT(message(content.substr(0, content.size() / 2)), HasSubstr(path + ":"));
}

}  // namespace
}  // namespace corbslam
