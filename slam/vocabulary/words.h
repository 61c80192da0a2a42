// A picture as a bag of binary words (Galvez-Lopez and Tardos, T-RO 2012).
#ifndef CORBSLAM_SLAM_VOCABULARY_WORDS_H_
#define CORBSLAM_SLAM_VOCABULARY_WORDS_H_

#include <cstdint>
#include <vector>

namespace corbslam {

struct WordWeight {
  uint32_t word = 0;
  float weight = 0;  // TF-IDF; a bag's weights sum to 1.
  friend bool operator==(const WordWeight&, const WordWeight&) = default;
};

// The bag is sorted by word, with each word once.
using BagOfWords = std::vector<WordWeight>;

// Direct index: which features fell under which node of a middle level of the tree, so that
// only those need comparing. Sorted by node; features ascending.
struct NodeFeatures {
  uint32_t node = 0;
  std::vector<uint32_t> features;  // Indices of keypoints.
  friend bool operator==(const NodeFeatures&, const NodeFeatures&) = default;
};

struct Words {
  BagOfWords bag;
  std::vector<NodeFeatures> direct_index;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_WORDS_H_
