// Counts how many places are recognised by words alone.
#ifndef CORBSLAM_TESTS_BENCH_RECOGNITION_H_
#define CORBSLAM_TESTS_BENCH_RECOGNITION_H_

#include <cstddef>
#include <memory>
#include <vector>

#include "slam/geometry/rigid3.h"
#include "slam/vocabulary/words.h"

namespace corbslam::tests {

struct SeenPlace {
  // Poses of different scenes have nothing to do with each other.
  int scene = 0;
  Rigid3d world_from_camera;
  std::shared_ptr<const Words> words;
};

// Returns whether they are within 5 m and 30 degrees.
bool IsSamePlace(const SeenPlace& a, const SeenPlace& b);

struct Recognition {
  size_t right = 0;  // Queries whose best keyframe is the same place, whatever the score.
  // Queries that also score better than all wrong ones: recall@1 at 100 % precision.
  size_t found = 0;
  double worst_wrong = 0;  // Highest score of a wrong best.
};

// A query that has no place in the database finds a wrong one, or nothing.
Recognition Recognise(const std::vector<SeenPlace>& database,
                      const std::vector<SeenPlace>& queries);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_RECOGNITION_H_
