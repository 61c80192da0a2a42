#include "slam/fusing/map_alignment.h"

#include <algorithm>
#include <cmath>

#include "slam/map/scene_depth.h"

namespace corbslam {
namespace {

constexpr double kAgreementShareOfDepth = 0.1;
constexpr double kAgreementAngle_rad = 0.1;
constexpr double kAgreementLogScale = 0.1;

// Returns whether the overlap's mover comes to lie in the same place under the alignment that
// another overlap proposes.
bool Agrees(const Map& mover_map, const OrientedOverlap& overlap, const Similarity3d& own,
            const Similarity3d& proposed, double depth) {
  const Rigid3d& camera_from_map = mover_map.FindKeyframe(overlap.mover)->camera_from_map;
  const Eigen::Vector3d centre = CameraCentre(camera_from_map);
  const double distance = (own * centre - proposed * centre).norm();
  const double angle_rad = RotationAngle(own.rotation.conjugate() * proposed.rotation);
  const double stretch = std::abs(std::log(own.scale / proposed.scale));
  return distance < kAgreementShareOfDepth * depth && angle_rad < kAgreementAngle_rad &&
         stretch < kAgreementLogScale;
}

}  // namespace

OrientedOverlap Orient(const Overlap& overlap, bool swap) {
  OrientedOverlap oriented;
  oriented.anchor = swap ? overlap.query : overlap.candidate;
  oriented.mover = swap ? overlap.candidate : overlap.query;
  oriented.anchor_from_mover =
      swap ? overlap.candidate_from_query.Inverse() : overlap.candidate_from_query;
  // The other direction is (Exp(e) * T)^-1 = Exp(-Adjoint(T^-1) * e) * T^-1.
  const Matrix7d A = swap ? AdjointSim3(oriented.anchor_from_mover) : Matrix7d::Identity();
  oriented.covariance = A * overlap.covariance * A.transpose();
  for (const PointPair& pair : overlap.inliers) {
    oriented.points.emplace_back(swap ? pair.query : pair.candidate,
                                 swap ? pair.candidate : pair.query);
  }
  return oriented;
}

Similarity3d AlignByOverlap(const Map& anchor_map, const Map& mover_map,
                            const OrientedOverlap& overlap) {
  const Keyframe& anchor = *anchor_map.FindKeyframe(overlap.anchor);
  const Keyframe& mover = *mover_map.FindKeyframe(overlap.mover);
  return Similarity3d::FromRigid(anchor.camera_from_map.Inverse()) * overlap.anchor_from_mover *
         Similarity3d::FromRigid(mover.camera_from_map);
}

std::optional<Similarity3d> AlignByConsensus(const Map& anchor_map, const Map& mover_map,
                                             const std::vector<OrientedOverlap>& overlaps) {
  std::vector<Similarity3d> alignments;
  std::vector<double> depths;
  for (const OrientedOverlap& overlap : overlaps) {
    alignments.push_back(AlignByOverlap(anchor_map, mover_map, overlap));
    depths.push_back(MedianDepth(anchor_map, overlap));
  }
  std::optional<Similarity3d> best;
  size_t best_support = 0;
  for (size_t i = 0; i < overlaps.size(); ++i) {
    size_t support = 0;
    for (size_t j = 0; j < overlaps.size(); ++j) {
      if (i != j && !Agrees(mover_map, overlaps[j], alignments[j], alignments[i], depths[j])) {
        continue;
      }
      support += 1 + overlaps[j].points.size();
    }
    // Among equally supported overlaps the one with the most points of its own wins.
    support = support * 10000 + std::min<size_t>(overlaps[i].points.size(), 9999);
    if (support <= best_support) continue;
    best_support = support;
    best = alignments[i];
  }
  return best;
}

double MedianDepth(const Map& anchor_map, const OrientedOverlap& overlap) {
  const Keyframe* anchor = anchor_map.FindKeyframe(overlap.anchor);
  if (anchor == nullptr) return 1;
  std::vector<MapPointId> points;
  for (const auto& [anchor_point, mover_point] : overlap.points) points.push_back(anchor_point);
  std::optional<double> depth = MedianDepth(anchor_map, *anchor, points);
  if (!depth.has_value()) depth = MedianDepth(anchor_map, *anchor);
  return depth.value_or(1);
}

}  // namespace corbslam
