// Runs all that works on one local map: its map, tracking, mapping and loop closing, and their
// threads.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_LOCAL_MAP_SESSION_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_LOCAL_MAP_SESSION_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "client_agent/agent/place_index.h"
#include "client_agent/link/map_jobs.h"
#include "client_agent/loop_closing/loop_closer.h"
#include "client_agent/map/guarded_map.h"
#include "client_agent/mapping/mapper.h"
#include "client_agent/mapping/mapping_queue.h"
#include "client_agent/mapping/point_statistics.h"
#include "client_agent/shared/shared_map.h"
#include "client_agent/tracking/tracker.h"
#include "client_agent/upload/spooled_map.h"

namespace corbslam::client_agent {

struct LocalMapSessionOptions {
  LocalMapId local_map;
  TrackerOptions tracker;
  MapperOptions mapper;
  LoopCloserOptions loop_closer;
  FollowCorrection follow_correction;
  // Becomes MapperParts::local_ba_ms; not owned.
  SampleLog* local_ba_ms = nullptr;
};

// The session of one local map. Without Start it has no threads, and Step does their work.
class LocalMapSession : public MapJobs {
 public:
  LocalMapSession(const LocalMapSessionOptions& options, std::shared_ptr<const Camera> camera,
                  std::shared_ptr<const Vocabulary> vocabulary);
  ~LocalMapSession() override;
  LocalMapSession(const LocalMapSession&) = delete;
  LocalMapSession& operator=(const LocalMapSession&) = delete;

  // Goes on with what an earlier process spooled of this local map: the tracker is lost in it until
  // it recognises a place. To be called before all else.
  void GoOnFrom(const SpooledMap& spooled_map);

  void Start();
  // Steps mapping, then loop closing, until both are idle.
  void Step();
  // Waits for the threads instead: returns when all is idle, or false at the deadline.
  bool WaitUntilIdle(absl::Time deadline);
  // Waits likewise, then lets go of the newest keyframes that are not worth telling: the local map
  // ends, or the robot does.
  bool Settle(absl::Time deadline);
  // Returns whether Stop would cut nothing off. Without threads it is always so: WaitUntilIdle does
  // the work.
  bool IsIdle() const;
  // Ends the threads; the map stays. What waits in the queue is dropped. One thread at a time.
  void Stop();
  // Returns whether Stop has returned: the map does not change any more. Thread-safe.
  bool has_stopped() const { return has_stopped_; }

  void PostJob(std::function<void(GuardedMap&)> job) override { queue_.PostJob(std::move(job)); }
  // Keeps the place index in step with others' keyframes, and has own ones adjusted anew that were
  // fitted to what is gone.
  void OnPlaced(const PlacementChange& change, const Map& map) override;

  Tracker& tracker() { return tracker_; }
  GuardedMap& map() { return map_; }
  const GuardedMap& map() const { return map_; }
  const LoopCloser& loop_closer() const { return loop_closer_; }
  // Returns EstimateBytes of the map, as of the last keyframe that was mapped or the last change of
  // what others made.
  uint64_t map_bytes() const { return map_bytes_; }

 private:
  MapperParts MakeMapperParts(SampleLog* local_ba_ms);
  void OnMapped(KeyframeId id);

  const std::shared_ptr<const Vocabulary> vocabulary_;
  GuardedMap map_;
  std::atomic<uint64_t> map_bytes_ = 0;
  MappingQueue queue_;
  PointStatistics statistics_;
  MeasurementBook measurements_;
  PlaceIndex places_;
  const PlaceFinder find_places_;
  LoopCloser loop_closer_;
  Mapper mapper_;
  Tracker tracker_;
  std::vector<std::thread> threads_;
  std::atomic<bool> has_stopped_ = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_LOCAL_MAP_SESSION_H_
