#include "tests/bench/pairwise_consistency.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "slam/geometry/lie.h"

namespace corbslam::tests {
namespace {

// 95 % bound of chi2 with three degrees of freedom: positions alone are compared.
constexpr double kMaxChi2 = 7.815;

using Members = std::vector<size_t>;

double StepsBetween(KeyframeId a, KeyframeId b) {
  return std::abs(static_cast<double>(a.index) - static_cast<double>(b.index));
}

bool Agree(const AliasedGraph& graph, const PoseGraphEdge& p, const PoseGraphEdge& q) {
  const auto motion = [&graph](KeyframeId from, KeyframeId to) {
    return graph.initial.at(to) * graph.initial.at(from).Inverse();
  };
  const Similarity3d round =
      motion(q.a, p.a) * q.b_from_a.Inverse() * motion(p.b, q.b) * p.b_from_a;
  // The turns of each step move what comes after, so its variance grows with the way.
  double variance = 2 / p.weight;
  for (const auto& [from, to] : {std::pair(q.a, p.a), {p.b, q.b}}) {
    const double steps = StepsBetween(from, to);
    const double length_m = motion(from, to).translation.norm();
    variance +=
        steps * (1 / graph.odometry.front().weight +
                 length_m * length_m * graph.odometry_sigma_rad * graph.odometry_sigma_rad / 3);
  }
  return round.translation.squaredNorm() < kMaxChi2 * variance;
}

// Adds every overlap that agrees with all members so far, those with most friends first.
Members GrowFrom(size_t first, const std::vector<std::vector<bool>>& agree, const Members& ranked) {
  Members members = {first};
  for (const size_t next : ranked) {
    const bool fits = next != first && std::all_of(members.begin(), members.end(),
                                                   [&](size_t m) { return agree[m][next]; });
    if (fits) members.push_back(next);
  }
  return members;
}

Members LargestAgreeing(const AliasedGraph& graph, const Members& overlaps) {
  const size_t count = overlaps.size();
  std::vector<std::vector<bool>> agree(count, std::vector<bool>(count, false));
  std::vector<int> friends(count, 0);
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) {
      agree[i][j] =
          i != j && Agree(graph, graph.overlaps[overlaps[i]], graph.overlaps[overlaps[j]]);
      friends[i] += agree[i][j];
    }
  }
  Members ranked(count);
  for (size_t i = 0; i < count; ++i) ranked[i] = i;
  std::stable_sort(ranked.begin(), ranked.end(),
                   [&](size_t a, size_t b) { return friends[a] > friends[b]; });
  Members best;
  for (size_t i = 0; i < count; ++i) {
    Members members = GrowFrom(i, agree, ranked);
    if (members.size() > best.size()) best = std::move(members);
  }
  for (size_t& member : best) member = overlaps[member];
  return best;
}

}  // namespace

std::vector<double> ConsistentOverlaps(const AliasedGraph& graph) {
  std::map<std::pair<LocalMapId, LocalMapId>, Members> by_maps;
  for (size_t i = 0; i < graph.overlaps.size(); ++i) {
    const PoseGraphEdge& overlap = graph.overlaps[i];
    by_maps[{overlap.a.local_map, overlap.b.local_map}].push_back(i);
  }
  std::vector<double> weights(graph.overlaps.size(), 0.0);
  for (const auto& [maps, overlaps] : by_maps) {
    for (const size_t member : LargestAgreeing(graph, overlaps)) weights[member] = 1;
  }
  return weights;
}

}  // namespace corbslam::tests
