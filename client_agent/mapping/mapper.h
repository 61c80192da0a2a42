// Builds the local map from the keyframes that tracking keeps (ORB-SLAM, T-RO 2015, section VI).
// The mapper is the one writer of the map.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_MAPPER_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_MAPPER_H_

#include <deque>
#include <functional>
#include <vector>

#include "absl/functional/function_ref.h"
#include "client_agent/map/guarded_map.h"
#include "client_agent/mapping/culling.h"
#include "client_agent/mapping/keyframe_judgement.h"
#include "client_agent/mapping/mapping_queue.h"
#include "client_agent/mapping/measurement_book.h"
#include "client_agent/mapping/point_statistics.h"
#include "slam/optimisation/bundle_adjustment.h"
#include "slam/util/bounded_sample.h"

namespace corbslam::client_agent {

struct MapperOptions {
  BundleOptions local_bundle;
};

// What the mapper works with; nothing is owned.
struct MapperParts {
  GuardedMap* map = nullptr;
  MappingQueue* queue = nullptr;
  PointStatistics* statistics = nullptr;
  // Called on the mapping thread after a keyframe was mapped, without a lock held; may be null.
  std::function<void(KeyframeId)> on_mapped;
  // Called in the same way when a keyframe was culled; may be null.
  std::function<void(KeyframeId)> on_removed;
  // What tracking adds to keyframes' measurements; may be null.
  MeasurementBook* measurements = nullptr;
  // Hears how long each local bundle adjustment took, in milliseconds; may be null.
  SampleLog* local_ba_ms = nullptr;
};

// One thread, the mapping thread, calls Step and Run.
class Mapper {
 public:
  Mapper(const MapperOptions& options, MapperParts parts);

  // Inserts the keyframes that wait, and does one piece of work: a job, or the mapping of a
  // keyframe, in turn where there are both. False when there was nothing to do.
  bool Step();
  // Steps until the queue is stopped; waits where there is nothing to do.
  void Run();
  // Adjusts what lies around an own keyframe; does nothing where that is not in the map.
  void AdjustLocalBundle(KeyframeId centre);
  // Adjusts all own keyframes from this one on together, the newest kMostTogether of them.
  void AdjustSince(KeyframeId first);
  // Lets go of the newest keyframes that say little of ground which others know, as the local map
  // ends.
  void JudgeNewest();

 private:
  void Insert(const NewKeyframe& keyframe);
  // Inserts all keyframes that wait: tracking needs their points, whatever else there is to do.
  void InsertWaiting();
  void MapNextKeyframe();
  void MapKeyframe(KeyframeId id);
  using ChooseScope = absl::FunctionRef<BundleScope(const Map&)>;
  void AdjustScope(ChooseScope choose, KeyframeId about);
  void CommitBundle(const BundleResult& result, const Map& before);
  void CullKeyframes(KeyframeId centre);
  void JudgeKeyframes();
  void TellRemoved(const std::vector<KeyframeId>& removed) const;
  void ApplyMeasurements();

  static constexpr size_t kMostTogether = 150;

  const MapperOptions options_;
  const MapperParts parts_;
  RecentPoints recent_points_;
  KeyframeJudge judge_;
  // Keyframes that are inserted and not yet mapped.
  std::deque<KeyframeId> pending_;
  bool is_jobs_turn_ = true;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_MAPPER_H_
