#include "slam/optimisation/measurement_noise.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "slam/util/median.h"

namespace corbslam {
namespace {

// Medians of chi2 with two and three degrees of freedom.
constexpr double kMedianChi2Mono = 1.386;
constexpr double kMedianChi2Stereo = 2.366;
// The least variance is that of a tenth of a pixel: corners are not found better than that,
// whatever an exact scene says.
constexpr double kLeastVariance = 0.01;
// A pose with fewer observations says nothing of its own.
constexpr size_t kLeastObservations = 30;

size_t Coordinates(const BundleObservation& o) { return o.measured.has_depth ? 3 : 2; }

// Errors at the minimum are smaller than the noise: poses and points went along with it.
double ShareOfNoiseLeft(const BundleProblem& problem) {
  size_t measured = 0;
  std::vector<bool> seen(problem.points.size());
  for (const BundleObservation& o : problem.observations) {
    if (!o.is_used) continue;
    measured += Coordinates(o);
    if (o.point < problem.free_points) seen[o.point] = true;
  }
  const auto points = static_cast<size_t>(std::count(seen.begin(), seen.end(), true));
  const size_t unknowns = 6 * size_t{problem.free_poses} + 3 * points;
  if (measured <= unknowns) return 0;
  return static_cast<double>(measured - unknowns) / static_cast<double>(measured);
}

}  // namespace

std::vector<double> MeasureNoise(const BundleProblem& problem) {
  const double left = ShareOfNoiseLeft(problem);
  if (left == 0) return std::vector<double>(problem.poses.size(), 1);
  std::vector<double> all;
  std::vector<std::vector<double>> of_pose(problem.poses.size());
  for (const BundleObservation& o : problem.observations) {
    if (!o.is_used) continue;
    const double median = o.measured.has_depth ? kMedianChi2Stereo : kMedianChi2Mono;
    all.push_back(ObservationChi2(problem, o) / (median * left));
    of_pose[o.pose].push_back(all.back());
  }
  const double overall = std::clamp(Median(std::move(all)), kLeastVariance, 1.0);
  std::vector<double> variances;
  variances.reserve(of_pose.size());
  for (std::vector<double>& own : of_pose) {
    variances.push_back(own.size() < kLeastObservations
                            ? overall
                            : std::clamp(Median(std::move(own)), overall, 1.0));
  }
  return variances;
}

}  // namespace corbslam
