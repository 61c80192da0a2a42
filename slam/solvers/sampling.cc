#include "slam/solvers/sampling.h"

#include <algorithm>
#include <cmath>

namespace corbslam {

int RequiredIterations(size_t inliers, size_t count, int sample_size, double confidence,
                       int max_iterations) {
  if (inliers == 0 || count == 0) return max_iterations;
  const double share = static_cast<double>(inliers) / static_cast<double>(count);
  const double miss = 1 - std::pow(share, sample_size);
  if (miss <= 0) return std::min(1, max_iterations);
  if (miss >= 1) return max_iterations;
  const double needed = std::ceil(std::log(1 - confidence) / std::log(miss));
  return static_cast<int>(std::clamp(needed, 1.0, static_cast<double>(max_iterations)));
}

}  // namespace corbslam
