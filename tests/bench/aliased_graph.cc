#include "tests/bench/aliased_graph.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <utility>

#include "slam/geometry/lie.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::tests {
namespace {

constexpr double kRadius_m = 30;
constexpr double kStepDegrees = 5;
// Both robots see so much of the ring where they meet.
constexpr double kSharedDegrees = 40;
// Standard deviations of a step of 2.6 m.
constexpr double kOdometrySigma_m = 0.025;
constexpr double kOdometrySigma_rad = 0.002;
constexpr double kOdometryTurnSigma_rad = 0.001;  // All of a robot's steps have the same turn.
constexpr double kOverlapSigma_m = 0.08;
constexpr double kOverlapSigma_rad = 0.005;
constexpr double kSamePlace_m = 3;
constexpr double kOtherPlace_m = 10;
// Two overlaps that agree to within this agree on where a map lies.
constexpr double kAgreement_m = 1;
constexpr double kAgreement_rad = 0.1;

using Pair = std::pair<KeyframeId, KeyframeId>;

LocalMapId MapId(int index) { return LocalMapId{static_cast<uint64_t>(index) + 1}; }

class Maker {
 public:
  explicit Maker(const AliasedGraphOptions& options) : options_(options), random_(options.seed) {}

  AliasedGraph Make() {
    for (int map = 0; map < options_.maps; ++map) Drive(map);
    AddTrueOverlaps();
    AddWrongOverlaps();
    PlaceMaps();
    graph_.fixed.insert(KeyframeId{MapId(0), 0});
    graph_.odometry_sigma_rad = std::hypot(kOdometrySigma_rad, kOdometryTurnSigma_rad);
    return std::move(graph_);
  }

 private:
  double Normal(double sigma) { return std::normal_distribution<double>(0, sigma)(random_); }
  double Even(double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random_);
  }
  size_t Index(size_t count) { return random_() % count; }

  Rigid3d Noise(double sigma_m, double sigma_rad) {
    Vector6d tangent;
    for (int i = 0; i < 3; ++i) tangent[i] = Normal(sigma_m);
    for (int i = 3; i < 6; ++i) tangent[i] = Normal(sigma_rad);
    return ExpSE3(tangent);
  }

  const Rigid3d& Truth(KeyframeId id) const { return graph_.true_camera_from_world.at(id); }
  Rigid3d TrueMotion(KeyframeId from, KeyframeId to) const {
    return Truth(to) * Truth(from).Inverse();
  }
  double TrueDistance_m(const Pair& pair) const {
    return (CameraCentre(Truth(pair.first)) - CameraCentre(Truth(pair.second))).norm();
  }

  void Drive(int map) {
    const double arc = 360.0 / options_.maps;
    // Keyframes lie off the others', so that no two see exactly the same.
    const double begin = map * arc + 0.3 * kStepDegrees * map;
    const int count = static_cast<int>((arc + kSharedDegrees) / kStepDegrees);
    const auto poses = testing::PosesOnRing(begin, kStepDegrees, count, kRadius_m);
    const Rigid3d turn =
        ExpSE3((Vector6d() << 0, 0, 0, 0, Normal(kOdometryTurnSigma_rad), 0).finished());
    Rigid3d camera_from_map;
    for (uint32_t k = 0; k < poses.size(); ++k) {
      const KeyframeId id{MapId(map), k};
      graph_.true_camera_from_world[id] = poses[k];
      if (k > 0) {
        const KeyframeId previous{MapId(map), k - 1};
        const Rigid3d measured =
            Noise(kOdometrySigma_m, kOdometrySigma_rad) * turn * TrueMotion(previous, id);
        graph_.odometry.push_back({previous, id, Similarity3d::FromRigid(measured),
                                   1 / (kOdometrySigma_m * kOdometrySigma_m)});
        camera_from_map = measured * camera_from_map;
      }
      graph_.initial[id] = Similarity3d::FromRigid(camera_from_map);
    }
  }

  void AddOverlap(const Pair& pair, const Rigid3d& second_from_first, bool is_wrong) {
    const Rigid3d measured = Noise(kOverlapSigma_m, kOverlapSigma_rad) * second_from_first;
    graph_.overlaps.push_back({pair.first, pair.second, Similarity3d::FromRigid(measured),
                               1 / (kOverlapSigma_m * kOverlapSigma_m), true});
    graph_.is_wrong.push_back(is_wrong);
  }

  template <typename Condition>
  std::vector<Pair> FindPairs(Condition condition) const {
    std::vector<Pair> pairs;
    for (const auto& [a, pose_a] : graph_.true_camera_from_world) {
      for (const auto& [b, pose_b] : graph_.true_camera_from_world) {
        const Pair pair(a, b);
        if (a.local_map < b.local_map && condition(TrueDistance_m(pair))) pairs.push_back(pair);
      }
    }
    return pairs;
  }

  void AddTrueOverlaps() {
    std::vector<Pair> pairs = FindPairs([](double m) { return m < kSamePlace_m; });
    std::shuffle(pairs.begin(), pairs.end(), random_);
    // Every neighbour comes in turn, so that all maps hang together.
    std::map<std::pair<LocalMapId, LocalMapId>, std::vector<Pair>> by_maps;
    for (const Pair& pair : pairs) {
      by_maps[{pair.first.local_map, pair.second.local_map}].push_back(pair);
    }
    for (int added = 0; added < options_.true_overlaps;) {
      const int before = added;
      for (auto& [maps, left] : by_maps) {
        if (left.empty() || added == options_.true_overlaps) continue;
        AddOverlap(left.back(), TrueMotion(left.back().first, left.back().second), false);
        left.pop_back();
        ++added;
      }
      if (added == before) return;
    }
  }

  void AddWrongOverlaps() {
    const std::vector<Pair> pairs = FindPairs([](double m) { return m > kOtherPlace_m; });
    const double share = options_.wrong_share;
    int left = static_cast<int>(std::lround(options_.true_overlaps * share / (1 - share)));
    while (left > 0) {
      const Pair& pair = pairs[Index(pairs.size())];
      Vector6d tangent;
      for (int i = 0; i < 3; ++i) tangent[i] = Even(kSamePlace_m / std::numbers::sqrt3);
      for (int i = 3; i < 6; ++i) tangent[i] = Even(0.2);
      const Rigid3d second_from_first = ExpSE3(tangent);
      // The first's place is taken for the second's: the world moves by so much.
      const Rigid3d world_from_world =
          Truth(pair.second).Inverse() * second_from_first * Truth(pair.first);
      for (uint32_t k = 0; k < static_cast<uint32_t>(options_.cluster) && left > 0; ++k) {
        const Pair next{{pair.first.local_map, pair.first.index + k},
                        {pair.second.local_map, pair.second.index + k}};
        if (!graph_.initial.contains(next.first) || !graph_.initial.contains(next.second)) break;
        AddOverlap(next, Truth(next.second) * world_from_world * Truth(next.first).Inverse(), true);
        --left;
      }
    }
  }

  // Returns first_map_from_map by one overlap between `map` and one that has its place.
  Rigid3d AlignBy(const PoseGraphEdge& overlap, LocalMapId map) const {
    const Rigid3d b_from_a = overlap.b_from_a.ToRigid();
    const Rigid3d a = graph_.initial.at(overlap.a).ToRigid();
    const Rigid3d b = graph_.initial.at(overlap.b).ToRigid();
    return overlap.a.local_map == map ? b.Inverse() * b_from_a * a
                                      : a.Inverse() * b_from_a.Inverse() * b;
  }

  void PlaceMaps() {
    absl::btree_set<LocalMapId> placed = {MapId(0)};
    for (int map = 1; map < options_.maps; ++map) {
      Place(MapId(map), placed);
      placed.insert(MapId(map));
    }
  }

  void Place(LocalMapId map, const absl::btree_set<LocalMapId>& placed) {
    // The vector is where the mover is.
    std::vector<std::pair<Rigid3d, Eigen::Vector3d>> proposals;
    for (const PoseGraphEdge& overlap : graph_.overlaps) {
      const bool a_moves = overlap.a.local_map == map;
      if (!a_moves && overlap.b.local_map != map) continue;
      if (!placed.contains((a_moves ? overlap.b : overlap.a).local_map)) continue;
      const KeyframeId mover = a_moves ? overlap.a : overlap.b;
      proposals.emplace_back(AlignBy(overlap, map),
                             CameraCentre(graph_.initial.at(mover).ToRigid()));
    }
    const auto support = [&proposals](const Rigid3d& align) {
      return std::count_if(proposals.begin(), proposals.end(), [&align](const auto& other) {
        const Eigen::Vector3d difference = align * other.second - other.first * other.second;
        return difference.norm() < kAgreement_m &&
               RotationAngle(align.rotation.conjugate() * other.first.rotation) < kAgreement_rad;
      });
    };
    const auto best = std::max_element(
        proposals.begin(), proposals.end(),
        [&](const auto& a, const auto& b) { return support(a.first) < support(b.first); });
    if (best == proposals.end()) return;
    const Similarity3d map_from_first = Similarity3d::FromRigid(best->first.Inverse());
    for (auto& [id, pose] : graph_.initial) {
      if (id.local_map == map) pose = pose * map_from_first;
    }
  }

  const AliasedGraphOptions options_;
  std::mt19937_64 random_;
  AliasedGraph graph_;
};

}  // namespace

AliasedGraph MakeAliasedGraph(const AliasedGraphOptions& options) { return Maker(options).Make(); }

}  // namespace corbslam::tests
