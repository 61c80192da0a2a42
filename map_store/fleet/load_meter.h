// Makes a store's load of what is counted of it.
#ifndef CORBSLAM_MAP_STORE_FLEET_LOAD_METER_H_
#define CORBSLAM_MAP_STORE_FLEET_LOAD_METER_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "absl/time/time.h"
#include "map_store/fleet/directory.h"

namespace corbslam::map_store {

// A store's load and the parts of its missions in it.
struct WeighedStore {
  StoreLoad load;
  std::map<std::string, MissionWeight> missions = {};
  uint64_t waiting_requests = 0;  // To fusion workers.
};

// Averages over half a minute, about: what is older counts less and less. Not thread-safe.
class LoadMeter {
 public:
  struct Counted {
    uint64_t keyframes = 0;
    uint64_t bytes = 0;  // Of memory.
  };
  struct Reading {
    absl::Time time;
    double processor_s = 0;  // That the process has used since it began.
    double processors = 0;   // That it may use.
    uint64_t resident_bytes = 0;
    uint64_t budget_bytes = 0;
    std::map<std::string, Counted> missions = {};  // Those in memory.
  };

  // Returns the load once there was a reading before. What processors are busy with is divided
  // among missions by the keyframes that came to them.
  std::optional<WeighedStore> Note(const Reading& reading);

 private:
  struct Pace {
    uint64_t keyframes = 0;  // At the last reading.
    double keyframes_per_s = 0;
  };

  std::optional<Reading> last_;
  double busy_processors_ = 0;
  std::map<std::string, Pace> paces_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FLEET_LOAD_METER_H_
