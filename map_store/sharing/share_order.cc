#include "map_store/sharing/share_order.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "map_store/sharing/robot_places.h"
#include "map_store/view/sights.h"

namespace corbslam::map_store {
namespace {

using Waiting = std::set<KeyframeId>;

// As many keyframes may wait uncounted before all are counted again.
constexpr size_t kFew = 8;

bool AreCounted(const MissionState& state, const Waiting& waiting, const ShareNews& news) {
  if (news.counted_at_revision != state.global.revision) return false;
  const auto uncounted = std::ranges::count_if(
      waiting, [&news](KeyframeId id) { return !news.own_landmarks.contains(id); });
  return static_cast<size_t>(uncounted) <= kFew;
}

// Camera centres, of which the one nearest to a point is asked for again and again.
class Centres {
 public:
  explicit Centres(const IslandPoses& poses) {
    for (const auto& [id, pose] : poses) centres_.push_back(CameraCentre(pose.ToRigid()));
    std::sort(centres_.begin(), centres_.end(),
              [](const auto& a, const auto& b) { return a.x() < b.x(); });
  }

  // Returns the squared distance to the nearest centre: it searches outwards along x, until the
  // distance along x alone is greater than the least so far.
  double SquaredDistance(const Eigen::Vector3d& point) const {
    double least = std::numeric_limits<double>::max();
    const auto is_farther = [&](const Eigen::Vector3d& centre) {
      const double along_x = centre.x() - point.x();
      if (along_x * along_x > least) return true;
      least = std::min(least, (centre - point).squaredNorm());
      return false;
    };
    const auto middle =
        std::lower_bound(centres_.begin(), centres_.end(), point.x(),
                         [](const Eigen::Vector3d& centre, double x) { return centre.x() < x; });
    for (auto it = middle; it != centres_.end() && !is_farther(*it); ++it) {
    }
    for (auto it = std::make_reverse_iterator(middle); it != centres_.rend() && !is_farther(*it);
         ++it) {
    }
    return least;
  }

 private:
  std::vector<Eigen::Vector3d> centres_;  // By x.
};

// Makes what lies behind a robot seem farther away than it is, as the robot will hardly need it.
class Heading {
 public:
  // The robot has moved between its last two keyframes. It goes nowhere if it has only one.
  explicit Heading(const IslandPoses& own) {
    if (own.size() < 2) return;
    const auto newest = own.rbegin();
    robot_ = CameraCentre(newest->second.ToRigid());
    const Eigen::Vector3d motion = robot_ - CameraCentre(std::next(newest)->second.ToRigid());
    if (motion.norm() > kLeastMotion) direction_ = motion.normalized();
  }

  // Returns by what to multiply the distance of a point: 1 straight ahead, 2 straight behind.
  double Factor(const Eigen::Vector3d& point) const {
    const double distance = (point - robot_).norm();
    if (!(distance > 0)) return 1;
    return 1.5 - 0.5 * direction_.dot(point - robot_) / distance;
  }

 private:
  static constexpr double kLeastMotion = 1e-6;

  Eigen::Vector3d robot_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  // Of length 1 or 0.
};

}  // namespace

OwnLandmarkCount::OwnLandmarkCount(const MissionState& state, const Waiting& waiting,
                                   ShareState& share)
    : state_(state), waiting_(waiting), share_(share), revision_(state.global.revision) {
  // A robot that localises only has none.
  if (!share.local_map.IsValid()) return;
  if (waiting.size() <= kFew || AreCounted(state, waiting, share.news)) return;
  stage_ = Stage::kOwn;
  next_ = {share.local_map, 0};
}

bool OwnLandmarkCount::Next() {
  if (stage_ == Stage::kOwn) {
    const LocalMapState& own = *state_.FindLocalMap(share_.local_map);
    const auto it = own.map.keyframes().lower_bound(next_);
    if (it != own.map.keyframes().end()) {
      for (const auto& sight : SightsOf(state_, own, it->second)) {
        own_landmarks_.insert(sight.second);
      }
      next_ = {it->first.local_map, it->first.index + 1};
      return true;
    }
    stage_ = Stage::kWaiting;
    next_ = *waiting_.begin();
  }
  if (stage_ == Stage::kWaiting) {
    const auto it = waiting_.lower_bound(next_);
    if (it != waiting_.end()) {
      int& count = counts_[*it];
      if (const Keyframe* keyframe = state_.FindKeyframe(*it)) {
        for (const auto& sight : SightsOf(state_, *state_.FindLocalMap(it->local_map), *keyframe)) {
          if (own_landmarks_.contains(sight.second)) ++count;
        }
      }
      next_ = {it->local_map, it->index + 1};
      return true;
    }
    stage_ = Stage::kDone;
    share_.news.own_landmarks = std::move(counts_);
    share_.news.counted_at_revision = revision_;
  }
  return false;
}

std::vector<KeyframeId> OrderNewKeyframes(const MissionState& state, const Waiting& waiting,
                                          PoseCache& poses, const ShareState& share) {
  const bool many = waiting.size() > kFew;
  const auto own_landmarks = [many, &share](KeyframeId id) {
    const auto it = share.news.own_landmarks.find(id);
    return many && it != share.news.own_landmarks.end() ? it->second : 0;
  };
  const IslandPoses& own_poses = RobotPlaces(state, share, poses);
  const Centres own(own_poses);
  const Heading heading(own_poses);
  std::vector<std::tuple<int, double, KeyframeId>> ranked;
  for (const KeyframeId& id : waiting) {
    const IslandPoses& others = poses.Of(*state.FindLocalMap(id.local_map));
    // The owner may have removed the keyframe while landmarks were counted.
    const auto pose = others.find(id);
    if (pose == others.end()) continue;
    const Eigen::Vector3d centre = CameraCentre(pose->second.ToRigid());
    const double factor = many ? heading.Factor(centre) : 1;
    ranked.emplace_back(-own_landmarks(id), own.SquaredDistance(centre) * factor * factor, id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<KeyframeId> ids;
  for (const auto& [landmarks, distance, id] : ranked) ids.push_back(id);
  return ids;
}

}  // namespace corbslam::map_store
