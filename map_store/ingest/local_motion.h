// Says what an owner's later motion of its keyframes means for those that fusion has placed.
#ifndef CORBSLAM_MAP_STORE_INGEST_LOCAL_MOTION_H_
#define CORBSLAM_MAP_STORE_INGEST_LOCAL_MOTION_H_

#include <optional>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns the median depth of what the keyframe sees in its own local map; its camera's close depth
// (or 1) if it sees nothing.
double MedianDepth(const LocalMapState& local_map, const Keyframe& keyframe);

// Returns by how many pixels a scene at `depth` moves in an image of focal length `fx_px` when the
// camera moves by `motion`.
double PixelMotion(const Rigid3d& motion, double depth, double fx_px);

// Returns whether `motion` moves what the keyframe sees by more than `threshold_px`.
bool MovesMoreThan(double threshold_px, const Rigid3d& motion, const LocalMapState& local_map,
                   const Keyframe& keyframe);

// Returns whether the owner has moved the keyframe by more than `threshold_px` relative to its
// parent since both were placed; none unless both are in `placed`.
std::optional<bool> IsDisplaced(KeyframeId id, double threshold_px, const LocalMapState& local_map,
                                const PlacedKeyframes& placed);

// Marks a placed keyframe as displaced if, since it was placed, its owner has moved it relative to
// its (placed) parent by more than `threshold_px`. The global pose stays as it is until the next
// adjustment takes the new local relative pose as its start.
void NoteLocalMotion(KeyframeId id, double threshold_px, MissionState& state,
                     const LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_LOCAL_MOTION_H_
