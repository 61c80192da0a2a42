// Says what the link to the store asks of the thread that alone writes a local map.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_MAP_JOBS_H_
#define CORBSLAM_CLIENT_AGENT_LINK_MAP_JOBS_H_

#include <functional>

#include "client_agent/map/guarded_map.h"
#include "client_agent/shared/shared_map.h"

namespace corbslam::client_agent {

class MapJobs {
 public:
  virtual ~MapJobs() = default;

  // Runs the job on the writing thread, after those posted before. Thread-safe.
  virtual void PostJob(std::function<void(GuardedMap&)> job) = 0;
  // Hears which foreign keyframes came into, or went from, `map`; called on the writing thread,
  // while nobody else reads the map.
  virtual void OnPlaced(const PlacementChange& change, const Map& map) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_MAP_JOBS_H_
