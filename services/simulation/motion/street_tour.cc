#include "services/simulation/motion/street_tour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "services/simulation/dice.h"

namespace corbslam {
namespace {

constexpr double kShortestBlock_m = 60;
constexpr double kLongestBlock_m = 110;
// Below this there is one block to go round.
constexpr double kOneBlock_m = 500;
// Streets make up this share of the way: the rest is driven again.
constexpr double kStreetShare = 0.7;
// How much longer than asked for a way may get before it is scaled.
constexpr double kSlack_m = 60;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// The four directions are +z, +x, -z, -x.
constexpr int kDirections = 4;
int Opposite(int direction) { return (direction + 2) % kDirections; }

class StreetGrid {
 public:
  StreetGrid(const StreetTourOptions& options, Dice& dice) {
    const double length_m = std::max(options.length_m, 40.0);
    if (length_m < kOneBlock_m) {
      MakeCrossings(2, 2, 0.23 * length_m, 0.27 * length_m, 0.01 * length_m, dice);
      return;
    }
    int columns = 3;
    int rows = 3;
    constexpr double kMeanBlock_m = 0.5 * (kShortestBlock_m + kLongestBlock_m);
    while ((rows * (columns - 1) + columns * (rows - 1)) * kMeanBlock_m < kStreetShare * length_m) {
      (columns <= rows ? columns : rows) += 1;
    }
    MakeCrossings(columns, rows, kShortestBlock_m, kLongestBlock_m, 7, dice);
  }

  int crossings() const { return columns_ * rows_; }
  const Eigen::Vector2d& place(int crossing) const {
    return places_[static_cast<size_t>(crossing)];
  }
  // Returns -1 where there is no street.
  int Next(int crossing, int direction) const {
    const int column = crossing % columns_ + (direction == 1) - (direction == 3);
    const int row = crossing / columns_ + (direction == 0) - (direction == 2);
    const bool inside = column >= 0 && column < columns_ && row >= 0 && row < rows_;
    return inside ? row * columns_ + column : -1;
  }
  double Length(int from, int to) const { return (place(from) - place(to)).norm(); }

 private:
  void MakeCrossings(int columns, int rows, double shortest_m, double longest_m, double jitter_m,
                     Dice& dice) {
    columns_ = columns;
    rows_ = rows;
    const auto lines = [&](int count) {
      std::vector<double> at = {0};
      while (static_cast<int>(at.size()) < count) {
        at.push_back(at.back() + dice.Uniform(shortest_m, longest_m));
      }
      return at;
    };
    const std::vector<double> xs = lines(columns);
    const std::vector<double> zs = lines(rows);
    for (const double z : zs) {
      for (const double x : xs) {
        const double right = dice.Uniform(-jitter_m, jitter_m);
        places_.emplace_back(x + right, z + dice.Uniform(-jitter_m, jitter_m));
      }
    }
  }

  int columns_ = 0;
  int rows_ = 0;
  std::vector<Eigen::Vector2d> places_;
};

// An arrival is at a crossing, from a direction.
struct Arrival {
  int crossing = 0;
  int direction = 0;
};

// Takes the walk of MakeStreetTour: at random while it can still be home in time, then straight
// home.
class TourWalk {
 public:
  TourWalk(const StreetGrid& grid, double length_m, Dice& dice)
      : grid_(grid), target_m_(length_m), dice_(dice) {
    home_ = dice.Integer(0, grid.crossings() - 1);
    do {
      first_direction_ = dice.Integer(0, kDirections - 1);
    } while (grid.Next(home_, first_direction_) < 0);
    FindWaysHome();
  }

  StreetTour Walk() {
    tour_.crossings.push_back(grid_.place(home_));
    Arrival at{home_, first_direction_};
    Drive(first_direction_, at);
    while (!(IsHome(at) && tour_.length_m >= 0.9 * target_m_)) {
      int direction = ChooseAtRandom(at);
      if (direction < 0) {
        if (IsHome(at)) break;
        direction = WayHome(at);
      }
      tour_.crossings.push_back(grid_.place(at.crossing));
      Drive(direction, at);
    }
    return std::move(tour_);
  }

 private:
  bool IsHome(const Arrival& at) const {
    return at.crossing == home_ && at.direction != Opposite(first_direction_);
  }
  double& HomeDistance(const Arrival& at) {
    return home_m_[static_cast<size_t>(at.crossing)][static_cast<size_t>(at.direction)];
  }

  // Finds the distances home from every arrival, without turning back in a street.
  void FindWaysHome() {
    home_m_.assign(static_cast<size_t>(grid_.crossings()),
                   {kInfinite, kInfinite, kInfinite, kInfinite});
    for (bool changed = true; changed;) {
      changed = false;
      for (int crossing = 0; crossing < grid_.crossings(); ++crossing) {
        for (int direction = 0; direction < kDirections; ++direction) {
          const Arrival at{crossing, direction};
          double least_m = IsHome(at) ? 0 : kInfinite;
          for (int out = 0; out < kDirections; ++out) {
            least_m = std::min(least_m, DistanceHomeBy(at, out));
          }
          if (least_m < HomeDistance(at)) {
            HomeDistance(at) = least_m;
            changed = true;
          }
        }
      }
    }
  }

  double DistanceHomeBy(const Arrival& at, int direction) {
    const int next = grid_.Next(at.crossing, direction);
    if (next < 0 || direction == Opposite(at.direction)) return kInfinite;
    return grid_.Length(at.crossing, next) + HomeDistance({next, direction});
  }

  int WayHome(const Arrival& at) {
    int best = 0;
    for (int direction = 1; direction < kDirections; ++direction) {
      if (DistanceHomeBy(at, direction) < DistanceHomeBy(at, best)) best = direction;
    }
    return best;
  }

  // Streets that are new are taken more often. Returns -1 when the way would get too long.
  int ChooseAtRandom(const Arrival& at) {
    std::array<double, kDirections> weights = {};
    double sum = 0;
    for (int direction = 0; direction < kDirections; ++direction) {
      const double home_m = DistanceHomeBy(at, direction);
      if (tour_.length_m + home_m > target_m_ + kSlack_m) continue;
      const int times = Driven(at.crossing, grid_.Next(at.crossing, direction));
      weights[static_cast<size_t>(direction)] = times == 0 ? 1 : times == 1 ? 0.3 : 0.05;
      sum += weights[static_cast<size_t>(direction)];
    }
    if (sum == 0) return -1;
    double left = dice_.Uniform(0, sum);
    for (int direction = 0; direction < kDirections; ++direction) {
      left -= weights[static_cast<size_t>(direction)];
      if (left < 0) return direction;
    }
    return -1;
  }

  int Driven(int from, int to) const {
    const auto found = driven_.find(std::minmax(from, to));
    return found == driven_.end() ? 0 : found->second;
  }

  void Drive(int direction, Arrival& at) {
    const int next = grid_.Next(at.crossing, direction);
    const double street_m = grid_.Length(at.crossing, next);
    tour_.length_m += street_m;
    if (Driven(at.crossing, next) > 0) tour_.repeated_m += street_m;
    ++driven_[std::minmax(at.crossing, next)];
    at = {next, direction};
  }

  const StreetGrid& grid_;
  const double target_m_;
  Dice& dice_;
  int home_ = 0;
  int first_direction_ = 0;
  std::vector<std::array<double, kDirections>> home_m_;
  std::map<std::pair<int, int>, int> driven_;
  StreetTour tour_;
};

}  // namespace

StreetTour MakeStreetTour(const StreetTourOptions& options) {
  constexpr uint64_t kPurpose = 0x746F7572;
  Dice dice = Dice::For(options.seed, kPurpose, 0);
  const StreetGrid grid(options, dice);
  const double length_m = std::max(options.length_m, 40.0);
  StreetTour tour = TourWalk(grid, length_m, dice).Walk();
  const double scale = length_m / tour.length_m;
  for (Eigen::Vector2d& crossing : tour.crossings) crossing *= scale;
  tour.length_m *= scale;
  tour.repeated_m *= scale;
  return tour;
}

}  // namespace corbslam
