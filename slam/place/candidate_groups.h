// Candidates that see the same place support each other: the covisibility groups of ORB-SLAM
// (Mur-Artal and Tardos, ICRA 2014, section IV).
#ifndef CORBSLAM_SLAM_PLACE_CANDIDATE_GROUPS_H_
#define CORBSLAM_SLAM_PLACE_CANDIDATE_GROUPS_H_

#include <cstddef>
#include <vector>

#include "slam/map/map.h"
#include "slam/place/keyframe_database.h"

namespace corbslam {

struct CandidateGroup {
  PlaceCandidate best;
  // Sum of the members' scores.
  double score = 0;
  // Best first; best.id is among them.
  std::vector<KeyframeId> members;
};

// Groups around each candidate its most covisible keyframes of `map` that are candidates too.
// Groups are ordered by score, ties by the best keyframe's id, at most `max_groups`; of groups with
// the same best keyframe the better one stays, as do only groups with at least `min_score_of_best`
// of the first one's score. A candidate that is not in the map is a group of its own.
std::vector<CandidateGroup> GroupByCovisibility(const Map& map,
                                                const std::vector<PlaceCandidate>& candidates,
                                                size_t max_groups, double min_score_of_best = 0.75);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_PLACE_CANDIDATE_GROUPS_H_
