#include "client_agent/shared/own_places.h"

#include <cstddef>

namespace corbslam::client_agent {
namespace {

// Corrections remembered of one keyframe, so that a robot that is never told its places keeps no
// more.
constexpr size_t kMaxMotions = 8;

// Returns how far two poses of one keyframe differ, for comparison alone: metres (or the map's
// unit) and radians are added up.
double Difference(const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d motion = a * b.Inverse();
  return motion.translation.norm() + RotationAngle(motion.rotation);
}

// Returns how many of a keyframe's motions a pose of it contains: it is nearest to where they had
// led.
std::ptrdiff_t CountContained(const std::vector<OwnCorrection::Motion>& motions,
                              const Rigid3d& camera_from_local) {
  size_t nearest = motions.size();
  double least = Difference(camera_from_local, motions.back().camera_from_map_after);
  for (size_t i = motions.size(); i-- > 0;) {
    const double difference = Difference(camera_from_local, motions[i].camera_from_map_before);
    if (difference >= least) continue;
    least = difference;
    nearest = i;
  }
  return static_cast<std::ptrdiff_t>(nearest);
}

}  // namespace

Similarity3d OwnPlaces::Place::GlobalFromLocal() const {
  if (local_per_global == 1) return Similarity3d::FromRigid(LocalFromGlobal().Inverse());
  const Similarity3d camera_from_global_units = {local_per_global, camera_from_global.rotation,
                                                 local_per_global * camera_from_global.translation};
  return camera_from_global_units.Inverse() * Similarity3d::FromRigid(camera_from_local);
}

void OwnPlaces::Tell(const OwnKeyframePose& told) {
  Place& place = places_[told.id];
  place = {told.camera_from_global.ToRigid(), told.camera_from_local,
           told.camera_from_global.scale};
  const auto it = motions_.find(told.id);
  if (it == motions_.end()) return;
  Motions& motions = it->second;
  motions.erase(motions.begin(), motions.begin() + CountContained(motions, told.camera_from_local));
  for (const OwnCorrection::Motion& motion : motions) {
    place.camera_from_local = place.camera_from_local * motion.AfterFromBefore().Inverse();
  }
  if (motions.empty()) motions_.erase(it);
}

void OwnPlaces::ForgetGone(const Map& map) {
  const auto is_gone = [&map](const auto& entry) {
    return map.FindKeyframe(entry.first) == nullptr;
  };
  std::erase_if(motions_, is_gone);
  std::erase_if(places_, is_gone);
}

// Joins the two oldest motions into one where there are too many.
void OwnPlaces::Remember(const OwnCorrection::Motion& motion, Motions& motions) {
  motions.push_back(motion);
  if (motions.size() <= kMaxMotions) return;
  motions[1].camera_from_map_before = motions[0].camera_from_map_before;
  motions.erase(motions.begin());
}

void OwnPlaces::Correct(const OwnCorrection& correction) {
  for (const auto& [id, motion] : correction.motions) {
    Remember(motion, motions_[id]);
    const auto place = places_.find(id);
    if (place == places_.end()) continue;
    Rigid3d& camera_from_local = place->second.camera_from_local;
    camera_from_local = camera_from_local * motion.AfterFromBefore().Inverse();
  }
}

}  // namespace corbslam::client_agent
