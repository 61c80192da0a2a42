// What an owner's later motion of its keyframes means for those that fusion has placed.
#ifndef CORBSLAM_MAP_STORE_INGEST_LOCAL_MOTION_H_
#define CORBSLAM_MAP_STORE_INGEST_LOCAL_MOTION_H_

#include <optional>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Median depth of what the keyframe sees in its own local map; its camera's close depth (or 1)
// where it sees nothing.
double MedianDepth(const LocalMapState& local_map, const Keyframe& keyframe);

// By how many pixels a scene at `depth` moves in an image of focal length `fx_px` when the camera
// moves by `motion`.
double PixelMotion(const Rigid3d& motion, double depth, double fx_px);

// Whether that is more than `threshold_px` for what the keyframe sees.
bool MovesMoreThan(double threshold_px, const Rigid3d& motion, const LocalMapState& local_map,
                   const Keyframe& keyframe);

// Whether the owner has moved the keyframe by more than that relative to its parent since `placed`
// has both; none where it does not have both.
std::optional<bool> IsDisplaced(KeyframeId id, double threshold_px, const LocalMapState& local_map,
                                const PlacedKeyframes& placed);

// Marks a placed keyframe as displaced when, since it was placed, its owner has moved it relative
// to its (placed) parent by more than `threshold_px`. The global pose stays as it is until the
// next adjustment takes the new local relative pose as its start.
void NoteLocalMotion(KeyframeId id, double threshold_px, MissionState& state,
                     const LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_LOCAL_MOTION_H_
