#include "map_store/testing/test_agent.h"

#include <algorithm>
#include <utility>

#include "slam/util/status_macros.h"
#include "slam/vocabulary/trainer.h"

namespace corbslam::testing {

using map_store::MapStore;

std::shared_ptr<const Vocabulary> MakeTestVocabulary(const SyntheticWorld& world) {
  constexpr size_t kPictures = 20;
  PictureDescriptors pictures(kPictures);
  for (size_t i = 0; i < world.descriptors.size(); ++i) {
    pictures[i % kPictures].push_back(world.descriptors[i]);
  }
  TrainingOptions options;
  options.branching = 8;
  options.levels = 4;
  options.threads = 1;
  options.max_iterations = 4;
  return *Vocabulary::FromTree(*TrainVocabulary(options, pictures));
}

void SharedMirror::Apply(const SharedUpdate& update) {
  ++updates;
  revision = update.revision;
  if (update.restart) {
    ++restarts;
    keyframes.clear();
    points.clear();
    own.clear();
    landmarks.clear();
    global_from_local.reset();
  }
  if (update.global_from_local.has_value()) global_from_local = update.global_from_local;
  apart = update.apart;
  for (const SharedKeyframe& keyframe : update.keyframes) {
    keyframes[keyframe.payload->id] = keyframe;
  }
  for (const SharedMapPoint& point : update.points) points[point.id] = point;
  for (const SharedKeyframeMove& move : update.moved_keyframes) {
    keyframes.at(move.id).camera_from_global = move.camera_from_global;
  }
  for (const SharedMapPointMove& move : update.moved_points) {
    points.at(move.id).position_in_global = move.position_in_global;
  }
  for (const ObservationChange& change : update.observations) {
    MapPointId& seen = keyframes.at(change.keyframe).points.at(change.keypoint);
    seen = change.kind == ObservationChange::Kind::kAdded ? change.point : MapPointId();
  }
  for (const Landmark& landmark : update.landmarks) {
    landmarks[landmark.survivor] = landmark.members;
    for (const MapPointId& member : landmark.members) points.erase(member);
  }
  for (const OwnKeyframePose& pose : update.own_keyframes) own[pose.id] = pose.camera_from_global;
  for (const KeyframeId& id : update.removed_keyframes) keyframes.erase(id);
  for (const MapPointId& id : update.removed_points) points.erase(id);
}

TestAgent::TestAgent(MapStore& store, std::string mission, std::string name,
                     const SyntheticMap& made)
    : store_(store),
      mission_(std::move(mission)),
      name_(std::move(name)),
      made_(made),
      local_map_(made.map.keyframes().begin()->first.local_map) {
  Resume({}).IgnoreError();
}

absl::Status TestAgent::Resume(const ShareScope& scope) {
  SessionRequest request;
  request.mission = mission_;
  request.agent = name_;
  request.last_revision = mirror_.revision;
  request.local_maps = {local_map_};
  request.share = scope;
  ASSIGN_OR_RETURN(const MapStore::OpenedSession opened, store_.OpenSession(request));
  session_ = opened.session_id;
  return absl::OkStatus();
}

void TestAgent::AddPoints(const Keyframe& keyframe, MapUpdateBatch& batch) {
  for (uint32_t keypoint = 0; keypoint < keyframe.points.size(); ++keypoint) {
    const MapPointId id = keyframe.points[keypoint];
    if (!id.IsValid()) continue;
    const MapPoint& point = *made_.map.FindPoint(id);
    if (point.reference == keyframe.id()) {
      batch.full_points.push_back({id, point.position_in_map, point.reference, point.descriptor,
                                   point.normal_in_map, point.min_distance, point.max_distance});
    }
    batch.observations.push_back({ObservationChange::Kind::kAdded, id, keyframe.id(), keypoint});
  }
}

MapUpdateBatch TestAgent::EmptyBatch() {
  MapUpdateBatch batch;
  batch.local_map = local_map_;
  batch.number = next_number_++;
  return batch;
}

MapUpdateBatch TestAgent::NextBatch(size_t keyframes) {
  MapUpdateBatch batch = EmptyBatch();
  for (size_t i = 0; i < keyframes; ++i, ++next_keyframe_) {
    const Keyframe* keyframe = made_.map.FindKeyframe(Id(next_keyframe_));
    if (keyframe == nullptr) break;
    if (next_keyframe_ == 0) batch.cameras = {keyframe->payload->camera};
    batch.full_keyframes.push_back(
        {keyframe->payload, keyframe->camera_from_map, keyframe->parent});
    AddPoints(*keyframe, batch);
    batch.tracked_frames.push_back(
        {keyframe->payload->timestamp_ns, keyframe->id(), Rigid3d::Identity()});
  }
  return batch;
}

absl::Status TestAgent::Send(const MapUpdateBatch& batch) {
  return store_.Apply(session_, batch).status();
}

absl::Status TestAgent::Stream(size_t keyframes) {
  const size_t left = made_.map.keyframes().size() - next_keyframe_;
  for (size_t i = 0; i < std::min(left, keyframes); ++i) RETURN_IF_ERROR(Send(NextBatch(1)));
  return absl::OkStatus();
}

absl::Status TestAgent::Close() {
  MapUpdateBatch batch = EmptyBatch();
  batch.closes_local_map = true;
  return Send(batch);
}

absl::Status TestAgent::TakeShared(size_t byte_budget) {
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<SharedUpdate> update,
                     store_.NextShared(session_, byte_budget));
    if (!update.has_value()) return absl::OkStatus();
    mirror_.Apply(*update);
  }
}

}  // namespace corbslam::testing
