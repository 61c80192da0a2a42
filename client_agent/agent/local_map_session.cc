#include "client_agent/agent/local_map_session.h"

#include <utility>

#include "absl/time/clock.h"
#include "client_agent/map/map_bytes.h"
#include "slam/util/named_thread.h"

namespace corbslam::client_agent {

LocalMapSession::LocalMapSession(const LocalMapSessionOptions& options,
                                 std::shared_ptr<const Camera> camera,
                                 std::shared_ptr<const Vocabulary> vocabulary)
    : vocabulary_(std::move(vocabulary)),
      map_(options.local_map),
      places_(&map_),
      find_places_([this](const Words& words) { return places_.Find(words); }),
      loop_closer_(
          options.loop_closer, &map_, &queue_,
          [this](const Keyframe& query, const absl::btree_set<KeyframeId>& excluded) {
            return places_.FindLoops(query, excluded);
          },
          options.follow_correction),
      mapper_(options.mapper, MakeMapperParts(options.local_ba_ms)),
      tracker_(options.tracker, std::move(camera),
               {&map_, &queue_, &statistics_, vocabulary_.get(), &find_places_, &measurements_}) {}

LocalMapSession::~LocalMapSession() { Stop(); }

MapperParts LocalMapSession::MakeMapperParts(SampleLog* local_ba_ms) {
  MapperParts parts{&map_, &queue_, &statistics_, nullptr, nullptr, &measurements_, local_ba_ms};
  parts.on_mapped = [this](KeyframeId id) { OnMapped(id); };
  parts.on_removed = [this](KeyframeId id) { places_.Remove(id); };
  return parts;
}

void LocalMapSession::OnMapped(KeyframeId id) {
  const auto words = map_.Read([&](const Map& map) {
    map_bytes_ = EstimateBytes(map);
    const Keyframe* keyframe = map.FindKeyframe(id);
    return keyframe == nullptr ? nullptr : keyframe->words;
  });
  if (words == nullptr) return;
  places_.Add(id, words);
  loop_closer_.Enqueue(id);
}

void LocalMapSession::GoOnFrom(const SpooledMap& spooled_map) {
  map_.GoOnFrom(spooled_map.next_keyframe(), spooled_map.next_point());
  map_.Write([&](Map& map) {
    spooled_map.Fill(
        [this](const std::vector<Descriptor>& descriptors) {
          return std::make_shared<const Words>(vocabulary_->Transform(descriptors));
        },
        map);
    for (const auto& [id, keyframe] : map.keyframes()) places_.Add(id, keyframe.words);
    map_bytes_ = EstimateBytes(map);
  });
  tracker_.BeginLost();
}

void LocalMapSession::Start() {
  threads_.push_back(StartThread("mapping", [this] { mapper_.Run(); }));
  threads_.push_back(StartThread("loop detection", [this] {
    while (loop_closer_.WaitForDetection()) loop_closer_.StepDetection();
  }));
  threads_.push_back(StartThread("loop adjustment", [this] {
    while (loop_closer_.WaitForAdjustment()) loop_closer_.StepAdjustment();
  }));
}

void LocalMapSession::Step() {
  while (mapper_.Step() || loop_closer_.StepDetection() || loop_closer_.StepAdjustment()) {
  }
}

bool LocalMapSession::WaitUntilIdle(absl::Time deadline) {
  if (threads_.empty()) {
    Step();
    return true;
  }
  while (true) {
    if (!queue_.WaitUntilIdle(deadline) || !loop_closer_.WaitUntilIdle(deadline)) return false;
    // A loop that closed meanwhile has posted its correction.
    if (queue_.IsIdle() && loop_closer_.IsIdle()) return true;
  }
}

bool LocalMapSession::Settle(absl::Time deadline) {
  if (!WaitUntilIdle(deadline)) return false;
  PostJob([this](GuardedMap&) { mapper_.JudgeNewest(); });
  return WaitUntilIdle(deadline);
}

bool LocalMapSession::IsIdle() const {
  return threads_.empty() || (queue_.IsIdle() && loop_closer_.IsIdle());
}

void LocalMapSession::Stop() {
  loop_closer_.Stop();
  queue_.Stop();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  has_stopped_ = true;
}

void LocalMapSession::OnPlaced(const PlacementChange& change, const Map& map) {
  map_bytes_ = EstimateBytes(map);
  for (const KeyframeId id : change.removed_keyframes) places_.Remove(id);
  for (const KeyframeId id : change.added_keyframes) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe != nullptr) places_.Add(id, keyframe->words);
  }
  // A job each, so that new keyframes have their turn in between.
  for (const KeyframeId id : change.released_keyframes) {
    PostJob([this, id](GuardedMap&) { mapper_.AdjustLocalBundle(id); });
  }
  // One by one they come out of what they were fitted to as far as the ones beside them let them.
  if (change.released_keyframes.empty()) return;
  const KeyframeId first = change.released_keyframes.front();
  PostJob([this, first](GuardedMap&) { mapper_.AdjustSince(first); });
}

}  // namespace corbslam::client_agent
