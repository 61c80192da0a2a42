#include "client_agent/link/shared_inbox.h"

#include <utility>

namespace corbslam::client_agent {

size_t ApproximateBytes(const SharedUpdate& update) {
  constexpr size_t kFeatureBytes = sizeof(Keypoint) + sizeof(Descriptor) + sizeof(MapPointId);
  size_t bytes = sizeof(SharedUpdate);
  for (const SharedKeyframe& keyframe : update.keyframes) {
    bytes += sizeof(SharedKeyframe);
    bytes += kFeatureBytes * keyframe.payload->features.keypoints.size();
  }
  for (const Landmark& landmark : update.landmarks) {
    bytes += sizeof(Landmark) + landmark.members.size() * sizeof(MapPointId);
  }
  bytes += update.points.size() * sizeof(SharedMapPoint);
  bytes += update.moved_keyframes.size() * sizeof(SharedKeyframeMove);
  bytes += update.moved_points.size() * sizeof(SharedMapPointMove);
  bytes += update.observations.size() * sizeof(ObservationChange);
  bytes += update.own_keyframes.size() * sizeof(OwnKeyframePose);
  bytes += update.removed_keyframes.size() * sizeof(KeyframeId);
  bytes += update.removed_points.size() * sizeof(MapPointId);
  return bytes;
}

SharedInbox::SharedInbox(LocalMapId local_map, MapJobs& jobs, Uplink& uplink,
                         const InboxLimits& limits)
    : local_map_(local_map), jobs_(jobs), uplink_(uplink), limits_(limits), shared_(local_map) {}

void SharedInbox::Add(ArrivedUpdate update) {
  std::vector<ArrivedUpdate> updates;
  updates.push_back(std::move(update));
  AddAll(std::move(updates));
}

void SharedInbox::AddAll(std::vector<ArrivedUpdate> updates) {
  {
    absl::MutexLock lock(&mutex_);
    if (closed_ || updates.empty()) return;
    // A job that was posted before takes these updates with it. The job is posted under the lock,
    // so that none is posted after Close.
    if (updates_.empty()) {
      jobs_.PostJob([self = shared_from_this()](GuardedMap& map) { self->PlaceArrived(map); });
    }
    for (ArrivedUpdate& update : updates) {
      bytes_ += ApproximateBytes(update.update);
      updates_.push_back(std::move(update));
    }
    if (!IsFull()) return;
  }
  uplink_.PauseReading();
  // The mapping thread may have taken everything, and resumed, before the pause.
  if (!MustWait()) uplink_.ResumeReading();
}

bool SharedInbox::MustWait() const {
  absl::MutexLock lock(&mutex_);
  return !closed_ && IsFull();
}

void SharedInbox::Close() {
  {
    absl::MutexLock lock(&mutex_);
    closed_ = true;
    updates_.clear();
    bytes_ = 0;
  }
  uplink_.ResumeReading();
}

std::vector<ArrivedUpdate> SharedInbox::TakeArrived() {
  std::vector<ArrivedUpdate> arrived;
  bool was_full = false;
  {
    absl::MutexLock lock(&mutex_);
    was_full = IsFull();
    arrived.swap(updates_);
    bytes_ = 0;
  }
  if (was_full) uplink_.ResumeReading();
  return arrived;
}

void SharedInbox::PlaceArrived(GuardedMap& map) {
  for (const ArrivedUpdate& update : TakeArrived()) shared_.Apply(update);
  PlanAndPlace(map);
}

void SharedInbox::PlanAndPlace(GuardedMap& map) {
  // The plan is made while others read the map, too.
  const PlacementPlan plan = map.Read([this](const Map& now) { return shared_.Plan(now); });
  map.Write([&](Map& now) { Place(plan, now); });
}

void SharedInbox::Place(const PlacementPlan& plan, Map& map) {
  const PlacementChange change = shared_.Place(plan, map);
  {
    absl::MutexLock lock(&mutex_);
    global_from_local_ = shared_.GlobalFromLocal();
    global_is_in_metres_ = shared_.in_metres();
    keyframes_ = shared_.keyframe_count();
  }
  jobs_.OnPlaced(change, map);
}

void SharedInbox::Correct(const OwnCorrection& correction, GuardedMap& map) {
  const uint64_t own_moved = map.corrections();
  map.Write([&](Map& now) {
    shared_.Correct(correction, now);
    map.CountCorrection();
    absl::MutexLock lock(&mutex_);
    before_correction_ = std::exchange(global_from_local_, shared_.GlobalFromLocal());
    corrections_ = own_moved;
  });
  PlanAndPlace(map);
}

void SharedInbox::LeaveOut(LocalMapId foreign) {
  absl::MutexLock lock(&mutex_);
  if (closed_) return;
  jobs_.PostJob([self = shared_from_this(), foreign](GuardedMap& map) {
    map.Write([&](Map& now) {
      self->shared_.LeaveOut(
          foreign, [&map] { return map.NewPointId(); }, now);
    });
    self->PlanAndPlace(map);
  });
}

std::optional<Similarity3d> SharedInbox::GlobalFromLocal(uint64_t corrections) const {
  absl::MutexLock lock(&mutex_);
  return corrections < corrections_ ? before_correction_ : global_from_local_;
}

bool SharedInbox::GlobalIsInMetres() const {
  absl::MutexLock lock(&mutex_);
  return global_is_in_metres_;
}

size_t SharedInbox::keyframes() const {
  absl::MutexLock lock(&mutex_);
  return keyframes_;
}

}  // namespace corbslam::client_agent
