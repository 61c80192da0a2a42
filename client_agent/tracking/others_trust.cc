#include "client_agent/tracking/others_trust.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

// So many own points must agree with a pose that the others' are held against, and so many of
// theirs are a sample.
constexpr int kEnoughOwn = 50;
constexpr size_t kEnoughHearsay = 20;
// What a new frame counts in the mean over frames: about the last five.
constexpr double kShareOfNews = 0.2;
// Five standard deviations, at the median, contradict; half the variance ends it.
constexpr double kContradicts = 25;
constexpr double kFitsAgain = kContradicts / 2;
// Exact scenes have hardly any error of their own: it counts as a thirtieth of a pixel at least.
constexpr double kLeastOwnError2 = 1e-3;
constexpr double kMaxRatio = 100;

// Returns the frame's pose without hearsay; nullopt where own points do not determine it.
std::optional<Rigid3d> PoseByOwnSight(const Frame& frame,
                                      const absl::flat_hash_set<MapPointId>& hearsay) {
  Frame own = frame;
  for (Association& association : own.associations) {
    const bool is_own =
        association.kind == Association::Kind::kMapPoint && !hearsay.contains(association.id);
    if (!is_own) association = {};
  }
  const InlierCount inliers = OptimiseFramePose(frame.camera_from_map, LocalMapId(), own);
  if (inliers.map_points < kEnoughOwn) return std::nullopt;
  return own.camera_from_map;
}

struct Errors2 {
  std::vector<double> own;
  std::map<LocalMapId, std::vector<double>> hearsay;
};

Errors2 ErrorsAt(const Rigid3d& camera_from_map, const Frame& frame,
                 const absl::flat_hash_set<MapPointId>& hearsay) {
  Errors2 errors2;
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    const Association& association = frame.associations[i];
    if (association.kind != Association::Kind::kMapPoint) continue;
    const double error2 = NormalisedError2(frame, i, camera_from_map);
    const bool is_hearsay = hearsay.contains(association.id);
    (is_hearsay ? errors2.hearsay[association.id.local_map] : errors2.own).push_back(error2);
  }
  return errors2;
}

}  // namespace

std::optional<std::vector<Innovation>> MeasureInnovations(
    const Frame& frame, const absl::flat_hash_set<MapPointId>& hearsay) {
  if (hearsay.empty()) return std::nullopt;
  const std::optional<Rigid3d> pose = PoseByOwnSight(frame, hearsay);
  if (!pose.has_value()) return std::nullopt;
  Errors2 errors2 = ErrorsAt(*pose, frame, hearsay);
  const double own = std::max(Median(std::move(errors2.own)), kLeastOwnError2);
  std::vector<Innovation> innovations;
  for (auto& [local_map, of_hearsay] : errors2.hearsay) {
    if (of_hearsay.size() < kEnoughHearsay) continue;
    innovations.push_back({local_map, Median(std::move(of_hearsay)) / own});
  }
  return innovations;
}

void OthersTrust::Weigh(const absl::flat_hash_set<MapPointId>& hearsay, bool has_innovations,
                        Frame& frame) const {
  for (Association& association : frame.associations) {
    if (association.kind != Association::Kind::kMapPoint) continue;
    association.variance = 1;
    if (!hearsay.contains(association.id)) continue;
    const auto belief = beliefs_.find(association.id.local_map);
    if (belief == beliefs_.end()) continue;
    association.variance = belief->second.variance;
    if (belief->second.contradicts && has_innovations) association = {};
  }
}

// The mean is of logarithms, so that one frame of false matches does not outweigh the others.
std::vector<OthersNews> OthersTrust::Add(const std::vector<Innovation>& innovations) {
  std::vector<OthersNews> news;
  for (const Innovation& innovation : innovations) {
    Belief& belief = beliefs_[innovation.local_map];
    const double ratio = std::clamp(innovation.ratio, 1.0, kMaxRatio);
    belief.variance =
        std::exp((1 - kShareOfNews) * std::log(belief.variance) + kShareOfNews * std::log(ratio));
    const bool contradicts = belief.variance > (belief.contradicts ? kFitsAgain : kContradicts);
    if (contradicts == belief.contradicts) continue;
    belief.contradicts = contradicts;
    news.push_back({innovation.local_map, contradicts, std::sqrt(belief.variance)});
  }
  return news;
}

}  // namespace corbslam::client_agent
