#include "tests/bench/injected_fusing.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "slam/fusing/map_fusing.h"
#include "slam/fusing/testing/fused_maps.h"
#include "slam/geometry/lie.h"
#include "slam/util/status_macros.h"
#include "slam/verification/place_verification.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::tests {
namespace {

using testing::SyntheticMap;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};
constexpr double kStepDegrees = 3;
constexpr int kKeyframes = 30;
// Keyframe k of B lies between keyframes k + kMeetAt of A and the next.
constexpr uint32_t kMeetAt = 23;
constexpr int kWrongPairs = 30;
constexpr double kOtherPlace_m = 10;

struct Injected {
  Overlap overlap;
  bool is_wrong = false;
};

class Experiment {
 public:
  explicit Experiment(const InjectionOptions& options)
      : options_(options),
        random_(options.seed),
        world_(testing::MakeRingWorld(options.seed)),
        a_(testing::MakeSyntheticMap(
            world_, testing::PosesOnRing(0, kStepDegrees, kKeyframes),
            {.local_map = kA, .seed = 2 * options.seed, .drift_yaw_rad = 0.002})),
        b_(testing::MakeSyntheticMap(
            world_, testing::PosesOnRing((kMeetAt + 0.5) * kStepDegrees, kStepDegrees, kKeyframes),
            {.local_map = kB, .seed = 2 * options.seed + 1, .drift_scale = 0.01})) {}

  absl::StatusOr<InjectionResult> Run() {
    std::vector<Injected> overlaps = MakeOverlaps();
    if (options_.at_once) {
      RETURN_IF_ERROR(Offer(overlaps));
    } else {
      for (const Injected& one : overlaps) RETURN_IF_ERROR(Offer({one}));
    }
    if (is_fused_)
      result_.ate_m = testing::AteRmse_m(testing::PosesOf(fused_), testing::JoinTruth(a_, b_));
    return result_;
  }

 private:
  size_t Index(size_t count) { return random_() % count; }
  double Even(double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random_);
  }

  std::vector<MapPointId> PointsOf(const SyntheticMap& map, KeyframeId id) const {
    std::vector<MapPointId> points = map.map.FindKeyframe(id)->points;
    std::erase_if(points, [](MapPointId point) { return !point.IsValid(); });
    return points;
  }

  Overlap MakeWrong() {
    Overlap wrong;
    double distance_m = 0;
    while (distance_m < kOtherPlace_m) {
      wrong.query = {kB, static_cast<uint32_t>(Index(kKeyframes))};
      wrong.candidate = {kA, static_cast<uint32_t>(Index(kKeyframes))};
      distance_m = (CameraCentre(b_.true_camera_from_world.at(wrong.query)) -
                    CameraCentre(a_.true_camera_from_world.at(wrong.candidate)))
                       .norm();
    }
    Vector6d tangent;
    for (int i = 0; i < 3; ++i) tangent[i] = Even(3 / std::numbers::sqrt3);
    for (int i = 3; i < 6; ++i) tangent[i] = Even(0.2);
    wrong.candidate_from_query = Similarity3d::FromRigid(ExpSE3(tangent));
    std::vector<MapPointId> of_a = PointsOf(a_, wrong.candidate);
    std::vector<MapPointId> of_b = PointsOf(b_, wrong.query);
    std::shuffle(of_a.begin(), of_a.end(), random_);
    std::shuffle(of_b.begin(), of_b.end(), random_);
    for (size_t i = 0; i < std::min({of_a.size(), of_b.size(), size_t{kWrongPairs}}); ++i) {
      wrong.inliers.push_back({of_b[i], of_a[i]});
    }
    wrong.verdict = OverlapVerdict::kAccepted;
    return wrong;
  }

  // Makes the overlaps: a true one first, then the others in any order.
  std::vector<Injected> MakeOverlaps() {
    std::vector<Injected> overlaps;
    for (uint32_t k = 0; k + kMeetAt < kKeyframes; ++k) {
      Overlap overlap = VerifyPlace(b_.map, {kB, k}, a_.map, {kA, k + kMeetAt}, {});
      if (overlap.IsAccepted()) overlaps.push_back({std::move(overlap), false});
    }
    result_.true_overlaps = static_cast<int>(overlaps.size());
    result_.wrong_overlaps = static_cast<int>(
        std::lround(result_.true_overlaps * options_.wrong_share / (1 - options_.wrong_share)));
    for (int i = 0; i < result_.wrong_overlaps; ++i) overlaps.push_back({MakeWrong(), true});
    if (!overlaps.empty()) std::shuffle(overlaps.begin() + 1, overlaps.end(), random_);
    return overlaps;
  }

  // The store does so, too: points that have become one say nothing any more.
  Overlap Renamed(Overlap overlap) const {
    const auto survivor = [this](MapPointId id) {
      for (auto it = survivors_.find(id); it != survivors_.end(); it = survivors_.find(id)) {
        id = it->second;
      }
      return id;
    };
    for (PointPair& pair : overlap.inliers) {
      pair = {survivor(pair.query), survivor(pair.candidate)};
    }
    std::erase_if(overlap.inliers,
                  [](const PointPair& pair) { return pair.query == pair.candidate; });
    return overlap;
  }

  absl::Status Offer(const std::vector<Injected>& offered) {
    FuseMapsRequest request;
    request.target = is_fused_ ? fused_ : a_.map;
    if (!is_fused_) request.source = b_.map;
    for (const Overlap& overlap : accepted_) request.overlaps.push_back(Renamed(overlap));
    for (const Injected& one : offered) {
      request.new_overlaps.push_back(request.overlaps.size());
      request.overlaps.push_back(Renamed(one.overlap));
    }
    ASSIGN_OR_RETURN(const FuseMapsResult result, FuseMaps(request, {}, nullptr));
    if (!result.accepted) return absl::OkStatus();
    fused_ = testing::ApplyFusing(request.target, request.source, result);
    is_fused_ = true;
    for (const auto& merge : result.merges) survivors_[merge.member] = merge.survivor;
    for (const Injected& one : offered) {
      accepted_.push_back(one.overlap);
      ++(one.is_wrong ? result_.wrong_accepted : result_.true_accepted);
    }
    return absl::OkStatus();
  }

  const InjectionOptions options_;
  std::mt19937_64 random_;
  const testing::SyntheticWorld world_;
  const SyntheticMap a_;
  const SyntheticMap b_;
  InjectionResult result_;
  Map fused_;
  bool is_fused_ = false;
  std::vector<Overlap> accepted_;
  std::map<MapPointId, MapPointId> survivors_;
};

}  // namespace

absl::StatusOr<InjectionResult> FuseWithInjection(const InjectionOptions& options) {
  return Experiment(options).Run();
}

}  // namespace corbslam::tests
