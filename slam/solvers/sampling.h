// What our RANSAC loops share: seeded samples and the number of rounds still needed.
#ifndef CORBSLAM_SLAM_SOLVERS_SAMPLING_H_
#define CORBSLAM_SLAM_SOLVERS_SAMPLING_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>

namespace corbslam {

// Draws distinct indices; a seed gives the same on every platform. Not thread-safe.
class Sampler {
 public:
  explicit Sampler(uint64_t seed) : generator_(seed) {}

  // Returns kSize distinct indices below `count`, which must be at least kSize.
  template <size_t kSize>
  std::array<size_t, kSize> Draw(size_t count) {
    std::array<size_t, kSize> sample{};
    for (size_t i = 0; i < kSize; ++i) {
      do {
        sample[i] = static_cast<size_t>(generator_() % count);
      } while (Contains(sample, i));
    }
    return sample;
  }

 private:
  template <size_t kSize>
  static bool Contains(const std::array<size_t, kSize>& sample, size_t last) {
    for (size_t i = 0; i < last; ++i) {
      if (sample[i] == sample[last]) return true;
    }
    return false;
  }

  std::mt19937_64 generator_;
};

// Returns the samples needed to draw one of inliers alone with this confidence (Fischler and Bolles
// 1981); at most `max_iterations`.
int RequiredIterations(size_t inliers, size_t count, int sample_size, double confidence,
                       int max_iterations);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SOLVERS_SAMPLING_H_
