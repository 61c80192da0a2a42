// Smooth random functions: sums of sines.
#ifndef CORBSLAM_SERVICES_SIMULATION_MOTION_WAVES_H_
#define CORBSLAM_SERVICES_SIMULATION_MOTION_WAVES_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "services/simulation/dice.h"

namespace corbslam {

// A random function of mean 0 and the given standard deviation over a long stretch, with
// wavelengths between two bounds, in whatever unit the argument has. Deterministic in `seed`.
class Waves {
 public:
  Waves(uint64_t seed, double deviation, double shortest, double longest) {
    Dice dice(seed);
    constexpr int kSines = 6;
    for (int i = 0; i < kSines; ++i) {
      // One sine for each sixth of the bounds' ratio; longer ones are higher.
      const double share = (i + dice.Uniform(0.2, 0.8)) / kSines;
      const double length = shortest * std::pow(longest / shortest, share);
      const double turn = dice.Uniform(0, 2 * std::numbers::pi);
      sines_.push_back({std::sqrt(length) * deviation, 2 * std::numbers::pi / length,
                        dice.Uniform(0, 2 * std::numbers::pi),
                        Eigen::Vector2d(std::cos(turn), std::sin(turn))});
    }
    double squares = 0;
    for (const Sine& sine : sines_) squares += 0.5 * sine.height * sine.height;
    for (Sine& sine : sines_) {
      sine.height *= squares > 0 ? std::abs(deviation) / std::sqrt(squares) : 0;
    }
  }

  double operator()(double x) const {
    double sum = 0;
    for (const Sine& sine : sines_) sum += sine.height * std::sin(sine.rate * x + sine.phase);
    return sum;
  }
  // Makes waves over a plane: each sine runs in a direction of its own.
  double operator()(const Eigen::Vector2d& place) const {
    double sum = 0;
    for (const Sine& sine : sines_) {
      sum += sine.height * std::sin(sine.rate * sine.direction.dot(place) + sine.phase);
    }
    return sum;
  }
  Eigen::Vector2d Gradient(const Eigen::Vector2d& place) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Sine& sine : sines_) {
      sum += sine.height * sine.rate *
             std::cos(sine.rate * sine.direction.dot(place) + sine.phase) * sine.direction;
    }
    return sum;
  }

 private:
  struct Sine {
    double height;
    double rate;
    double phase;
    Eigen::Vector2d direction;
  };
  std::vector<Sine> sines_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_WAVES_H_
