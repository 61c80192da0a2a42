#include "services/simulation/motion/travel.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

constexpr double kTiny = 1e-9;

// Samples before and behind over which a change of heading is taken.
constexpr size_t kCurvatureReach = 3;

std::vector<double> Derivative(const std::vector<double>& values, double spacing) {
  std::vector<double> derivative(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const size_t before = i - std::min(i, kCurvatureReach);
    const size_t after = std::min(i + kCurvatureReach, values.size() - 1);
    derivative[i] = after > before ? (values[after] - values[before]) /
                                         (static_cast<double>(after - before) * spacing)
                                   : 0;
  }
  return derivative;
}

// Returns the least of the values up to `reach` before and behind.
std::vector<double> SlidingLeast(const std::vector<double>& values, size_t reach) {
  std::vector<double> least(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const auto begin = values.begin() + static_cast<ptrdiff_t>(i - std::min(i, reach));
    const auto end =
        values.begin() + static_cast<ptrdiff_t>(std::min(i + reach + 1, values.size()));
    least[i] = *std::min_element(begin, end);
  }
  return least;
}

std::vector<double> SlidingMean(const std::vector<double>& values, size_t reach) {
  std::vector<double> sums(values.size() + 1, 0.0);
  for (size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
  std::vector<double> means(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    // The mean reaches as far on both sides, so that the mean of a ramp lies on it.
    const size_t own = std::min({reach, i, values.size() - 1 - i});
    means[i] = (sums[i + own + 1] - sums[i - own]) / static_cast<double>(2 * own + 1);
  }
  return means;
}

// Returns the squares of the speeds that the path allows at each of its points.
std::vector<double> LimitSquares(const PlanePath& path, const std::vector<double>& curvatures,
                                 const TravelLimits& limits,
                                 const std::vector<double>& speeds_mps) {
  const std::vector<double> turns = Derivative(path.headings_rad, path.spacing_m);
  std::vector<double> squares(path.points.size());
  for (size_t i = 0; i < squares.size(); ++i) {
    double speed = limits.speed_mps;
    if (i < speeds_mps.size()) speed = std::min(speed, speeds_mps[i]);
    speed = std::min(speed, limits.yaw_rate_radps / std::max(std::abs(turns[i]), kTiny));
    speed =
        std::min(speed, std::sqrt(limits.lateral_mps2 / std::max(std::abs(curvatures[i]), kTiny)));
    speed = std::max(speed, limits.least_speed_mps);
    squares[i] = speed * speed;
  }
  return squares;
}

// Returns the fastest profile within the limits: least over a window, then as accelerating and
// braking allow, then the mean over the same window, which stays below what the window's middle
// allows.
std::vector<double> ProfileSquares(std::vector<double> squares, double spacing_m,
                                   const TravelLimits& limits) {
  const double reach_m =
      std::min(3.0, limits.speed_mps * limits.speed_mps / (8 * limits.brake_mps2));
  const auto reach = static_cast<size_t>(std::max(1.0, reach_m / spacing_m));
  squares = SlidingLeast(squares, reach);
  for (size_t i = 1; i < squares.size(); ++i) {
    squares[i] = std::min(squares[i], squares[i - 1] + 2 * limits.accelerate_mps2 * spacing_m);
  }
  for (size_t i = squares.size() - 1; i > 0; --i) {
    squares[i - 1] = std::min(squares[i - 1], squares[i] + 2 * limits.brake_mps2 * spacing_m);
  }
  return SlidingMean(squares, reach);
}

double Mix(const std::vector<double>& values, size_t i, double share) {
  return values[i] + share * (values[i + 1] - values[i]);
}

}  // namespace

std::vector<TravelSample> SampleTravel(const PlanePath& path, const TravelLimits& limits,
                                       double rate_hz, const std::vector<double>& speeds_mps) {
  std::vector<TravelSample> samples;
  if (path.points.size() < 2) return samples;
  const std::vector<double> curvatures = Derivative(ComputeHeadings(path.points), path.spacing_m);
  const std::vector<double> squares =
      ProfileSquares(LimitSquares(path, curvatures, limits, speeds_mps), path.spacing_m, limits);
  double leg_start_s = 0;
  for (size_t i = 0; i + 1 < path.points.size(); ++i) {
    const double speed = std::sqrt(squares[i]);
    const double next_speed = std::sqrt(squares[i + 1]);
    const double leg_s = 2 * path.spacing_m / (speed + next_speed);
    const double forward = (squares[i + 1] - squares[i]) / (2 * path.spacing_m);
    for (double time_s = static_cast<double>(samples.size()) / rate_hz;
         time_s < leg_start_s + leg_s; time_s = static_cast<double>(samples.size()) / rate_hz) {
      const double since_s = time_s - leg_start_s;
      const double since_m = speed * since_s + 0.5 * forward * since_s * since_s;
      const double share = std::clamp(since_m / path.spacing_m, 0.0, 1.0);
      TravelSample sample;
      sample.time_s = time_s;
      sample.distance_m = path.spacing_m * (static_cast<double>(i) + share);
      sample.position = path.points[i] + share * (path.points[i + 1] - path.points[i]);
      sample.heading_rad = Mix(path.headings_rad, i, share);
      sample.speed_mps = speed + forward * since_s;
      sample.forward_mps2 = forward;
      sample.lateral_mps2 = Mix(squares, i, share) * Mix(curvatures, i, share);
      samples.push_back(sample);
    }
    leg_start_s += leg_s;
  }
  return samples;
}

}  // namespace corbslam
