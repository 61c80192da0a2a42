#include "client_agent/loop_closing/loop_closer.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "client_agent/loop_closing/correction_view.h"
#include "glog/logging.h"
#include "slam/fusing/map_fusing.h"
#include "slam/optimisation/bundle_adjustment.h"
#include "slam/util/resident_memory.h"
#include "slam/verification/neighbourhood.h"

namespace corbslam::client_agent {
namespace {

// Keyframes that see so many points together stand well to each other already.
constexpr int kWellConnected = 15;
// Neighbours in the views that verification gets; one more than it looks at on either side, for
// shared ones.
constexpr int kViewNeighbours = 10;

// Returns keyframes that are no loop: the query's own surroundings in the graph and in time.
absl::btree_set<KeyframeId> SurroundingsOf(const Map& map, const Keyframe& query,
                                           uint32_t min_gap) {
  absl::btree_set<KeyframeId> surroundings = {query.id()};
  for (const CovisibleKeyframe& near : map.Covisible(query.id(), kWellConnected)) {
    surroundings.insert(near.id);
    for (const CovisibleKeyframe& second : map.Covisible(near.id, kWellConnected)) {
      surroundings.insert(second.id);
    }
  }
  const KeyframeId id = query.id();
  const uint32_t first = id.index - std::min(id.index, min_gap - std::min(min_gap, 1u));
  for (auto near = map.keyframes().lower_bound({id.local_map, first});
       near != map.keyframes().end() && near->first.local_map == id.local_map; ++near) {
    if (near->first.index > id.index && near->first.index - id.index >= min_gap) break;
    surroundings.insert(near->first);
  }
  return surroundings;
}

// Everything own may move but the root; others' keyframes and what they see stay.
BundleScope OwnMapScope(const Map& map, LocalMapId own) {
  BundleScope scope;
  const absl::btree_set<KeyframeId> stay = KeyframesThatStay(map, own);
  for (const auto& [id, keyframe] : map.keyframes()) {
    (stay.contains(id) ? scope.fixed_keyframes : scope.free_keyframes).push_back(id);
  }
  for (const auto& [id, point] : map.points()) {
    (MovesWith(own, point) ? scope.free_points : scope.fixed_points).push_back(id);
  }
  return scope;
}

}  // namespace

LoopCloser::LoopCloser(const LoopCloserOptions& options, GuardedMap* map, MappingQueue* queue,
                       FindLoopCandidates find_candidates, FollowCorrection follow)
    : options_(options),
      map_(*map),
      queue_(*queue),
      find_candidates_(std::move(find_candidates)),
      follow_(std::move(follow)) {}

void LoopCloser::Enqueue(KeyframeId keyframe) {
  absl::MutexLock lock(&mutex_);
  waiting_.push_back(keyframe);
  if (waiting_.size() > options_.max_waiting_keyframes) waiting_.pop_front();
}

bool LoopCloser::DetectionIsReady() const {
  return !waiting_.empty() && !correction_posted_ && !detecting_ && !stopped_;
}

bool LoopCloser::AdjustmentIsReady() const {
  return adjustment_wanted_ && !correction_posted_ && !adjusting_ && !stopped_;
}

bool LoopCloser::StepDetection() {
  KeyframeId query;
  {
    absl::MutexLock lock(&mutex_);
    if (!DetectionIsReady()) return false;
    query = waiting_.front();
    waiting_.pop_front();
    detecting_ = true;
    const bool is_soon = last_closed_at_.has_value() &&
                         query.index < last_closed_at_->index + options_.min_keyframe_gap;
    if (is_soon) {
      detecting_ = false;
      return true;
    }
  }
  const std::optional<Overlap> loop = DetectLoop(query);
  const bool is_closed = loop.has_value() && CloseLoop(*loop);
  absl::MutexLock lock(&mutex_);
  detecting_ = false;
  ++counts_.queried;
  if (is_closed) last_closed_at_ = query;
  return true;
}

std::optional<Overlap> LoopCloser::DetectLoop(KeyframeId query_id) {
  std::optional<Keyframe> query;
  absl::btree_set<KeyframeId> surroundings;
  map_.Read([&](const Map& map) {
    const Keyframe* keyframe = map.FindKeyframe(query_id);
    if (keyframe == nullptr || keyframe->words == nullptr) return;
    query = *keyframe;
    surroundings = SurroundingsOf(map, *keyframe, options_.min_keyframe_gap);
  });
  if (!query.has_value()) return std::nullopt;
  std::vector<KeyframeId> candidates = find_candidates_(*query, surroundings);
  if (candidates.size() > options_.max_candidates) candidates.resize(options_.max_candidates);

  PlaceVerificationOptions verification;
  verification.fix_scale = options_.fix_scale;
  verification.seed = options_.seed;
  verification.min_consistent_keyframes = options_.min_consistent_keyframes;
  for (const KeyframeId& candidate : candidates) {
    if (surroundings.contains(candidate)) continue;
    Map query_view;
    Map candidate_view;
    map_.Read([&](const Map& map) {
      query_view = ViewAround(map, query_id, kViewNeighbours);
      candidate_view = ViewAround(map, candidate, kViewNeighbours);
    });
    Overlap overlap = VerifyPlace(query_view, query_id, candidate_view, candidate, verification);
    absl::MutexLock lock(&mutex_);
    ++counts_.verified;
    if (overlap.IsAccepted()) return overlap;
  }
  return std::nullopt;
}

bool LoopCloser::CloseLoop(const Overlap& loop) {
  const LocalMapId own = map_.local_map();
  FuseMapsRequest request;
  request.target =
      map_.Read([&](const Map& map) { return CorrectionView(map, own, loop.candidate); });
  request.overlaps = {loop};
  request.new_overlaps = {0};
  request.fix_scale = options_.fix_scale;
  MapFusingOptions fusing;
  fusing.only_moves = own;
  fusing.threads = options_.solver_threads;
  const auto fused = FuseMaps(request, fusing, [this](double) { return !stopping_.load(); });
  if (!fused.ok() || !fused->accepted) {
    LOG(INFO) << "loop of keyframe " << ToString(loop.query) << " with " << ToString(loop.candidate)
              << " is refused: " << (fused.ok() ? "bends the graph" : fused.status().ToString());
    return false;
  }
  auto correction = std::make_shared<MapCorrection>(MakeCorrection(request.target, own, *fused));
  correction->loop_edge = {loop.query, loop.candidate};
  const bool against_others = loop.candidate.local_map != own;
  generation_.fetch_add(1);
  {
    absl::MutexLock lock(&mutex_);
    correction_posted_ = true;
    adjustment_wanted_ = true;
    ++counts_.closed;
    if (against_others) ++counts_.closed_against_others;
  }
  queue_.PostJob([this, correction](GuardedMap&) {
    Apply(*correction);
    absl::MutexLock lock(&mutex_);
    correction_posted_ = false;
  });
  return true;
}

void LoopCloser::Apply(const MapCorrection& correction) {
  OwnCorrection moved;
  moved.fixed = correction.fixed;
  map_.Write([&](Map& map) {
    moved.motions = ApplyCorrection(correction, map_.local_map(), map);
    map_.CountCorrection();
  });
  if (follow_) follow_(moved, map_);
}

bool LoopCloser::StepAdjustment() {
  {
    absl::MutexLock lock(&mutex_);
    if (!AdjustmentIsReady()) return false;
    adjusting_ = true;
    adjustment_wanted_ = false;
  }
  const ReturnsFreeMemory returns;  // Of a copy of the whole map, and as much again to adjust it.
  const uint64_t generation = generation_.load();
  const LocalMapId own = map_.local_map();
  const Map map =
      map_.Read([own](const Map& inner) { return CorrectionView(inner, own, std::nullopt); });
  BundleOptions bundle;
  bundle.max_iterations = options_.adjustment_iterations;
  bundle.measure_noise = true;
  bundle.threads = options_.solver_threads;
  bundle.keep_going = [this, generation](double) {
    return !stopping_.load() && generation_.load() == generation;
  };
  const auto adjusted = AdjustBundle(map, OwnMapScope(map, own), bundle);
  if (!adjusted.ok()) LOG(WARNING) << "full bundle adjustment: " << adjusted.status();
  const bool is_usable = adjusted.ok() && !adjusted->cancelled && generation_.load() == generation;
  if (!is_usable) {
    absl::MutexLock lock(&mutex_);
    adjusting_ = false;
    return true;
  }
  auto correction = std::make_shared<MapCorrection>(MakeCorrection(map, own, *adjusted));
  queue_.PostJob([this, generation, correction](GuardedMap&) {
    // A loop that was closed since then has moved the map that this was computed on.
    const bool is_current = generation_.load() == generation;
    if (is_current) Apply(*correction);
    absl::MutexLock lock(&mutex_);
    adjusting_ = false;
    if (is_current) ++counts_.adjusted;
  });
  return true;
}

bool LoopCloser::WaitForDetection() {
  absl::MutexLock lock(&mutex_);
  const auto ready = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopped_ || DetectionIsReady();
  };
  mutex_.Await(absl::Condition(&ready));
  return !stopped_;
}

bool LoopCloser::WaitForAdjustment() {
  absl::MutexLock lock(&mutex_);
  const auto ready = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopped_ || AdjustmentIsReady();
  };
  mutex_.Await(absl::Condition(&ready));
  return !stopped_;
}

void LoopCloser::Stop() {
  stopping_.store(true);
  absl::MutexLock lock(&mutex_);
  stopped_ = true;
}

bool LoopCloser::IsIdle() const {
  absl::MutexLock lock(&mutex_);
  return Idle();
}

bool LoopCloser::WaitUntilIdle(absl::Time deadline) const {
  absl::MutexLock lock(&mutex_);
  const auto idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return Idle(); };
  return mutex_.AwaitWithDeadline(absl::Condition(&idle), deadline);
}

bool LoopCloser::Idle() const {
  if (stopped_) return !detecting_ && !adjusting_;
  return waiting_.empty() && !detecting_ && !correction_posted_ && !adjusting_ &&
         !adjustment_wanted_;
}

LoopCloserCounts LoopCloser::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

}  // namespace corbslam::client_agent
