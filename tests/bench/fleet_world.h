// The state of a simulated fleet (fleet_simulation.h), and its clock.
#ifndef CORBSLAM_TESTS_BENCH_FLEET_WORLD_H_
#define CORBSLAM_TESTS_BENCH_FLEET_WORLD_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <queue>
#include <unordered_map>
#include <vector>

#include "absl/time/time.h"
#include "client_agent/link/backoff.h"
#include "map_store/fleet/directory.h"
#include "map_store/fleet/lease_rules.h"
#include "map_store/fleet/load_meter.h"

namespace corbslam::tests {

// Nanoseconds since the beginning.
using Nanos = int64_t;
inline constexpr Nanos kNever = INT64_MIN / 4;
inline constexpr uint32_t kNobody = UINT32_MAX;
// A peer that says nothing is given up after (services/client/remote/channel.h), and a database
// that is not reached after (PostgresJournalOptions::connect_timeout).
inline constexpr Nanos kSilence = 30'000'000'000;
inline constexpr Nanos kDatabaseTimeout = 5'000'000'000;

// A mission's row in its database, and what its log has.
struct SimulatedMission {
  int64_t holder = 0;
  int64_t epoch = 0;
  Nanos lease_until = kNever;  // By the database's clock.
  uint32_t wanted = kNobody;   // A store.
  Nanos moved_at = kNever;
  // What only the simulation knows: who took the mission in this epoch; when it was last served;
  // when it was last moved to balance loads.
  int64_t taken_by = 0;
  Nanos served_at = 0;
  Nanos balanced_at = kNever;
  float weight = 0;  // Processors, with all its robots connected.
};

// A mission as a store has it in memory.
struct LoadedMission {
  enum class Stage { kTaking, kReady, kClosing };
  Stage stage = Stage::kTaking;
  int64_t epoch = 0;
  std::vector<uint32_t> known = {};    // Up to which batch it has each robot's.
  std::vector<uint32_t> waiting = {};  // Robots that asked for it.
};

struct SimulatedStore {
  int64_t process = 0;  // 0: it is dead.
  Nanos paused_until = kNever;
  bool reaches_database = true;
  bool reached_by_robots = true;
  double clock_rate = 1;
  std::unique_ptr<map_store::OwnLease> own_lease;
  map_store::StoreDuty duty = map_store::StoreDuty::kTakesMissions;  // As it was told last.
  std::unordered_map<uint32_t, LoadedMission> loaded;
  Nanos loader_free_at = 0;
  map_store::LoadMeter meter;
  std::optional<map_store::WeighedStore> weighed;
  double processor_s = 0;
  Nanos metered_at = 0;
  std::vector<uint32_t> sessions;  // Robots, some of which have gone.
  // Its row in the database.
  int64_t row_holder = 0;
  Nanos row_lease_until = kNever;
  map_store::StoreDuty row_duty = map_store::StoreDuty::kTakesMissions;
  std::optional<map_store::StoreLoad> row_load;
  Nanos row_balanced_at = kNever;
  std::vector<uint32_t> row_missions;  // That it holds, or held a moment ago.
};

struct SimulatedRobot {
  uint32_t store = kNobody;  // That it has a session with.
  uint32_t turn = 0;  // Grows with each session and attempt: what belongs to older ones is void.
  uint32_t acknowledged = 0;  // Batches.
  uint32_t stored = 0;        // That the database has: of the log.
  uint32_t next_named = 0;    // Which address of the fleet's name comes next.
  uint8_t hops = 0;
  std::unique_ptr<client_agent::Backoff> backoff;  // While it is not served.
};

struct SimulatedDatabase {
  bool is_up = true;
  Nanos clock_ahead = 0;
  Nanos changed_at =
      0;                // When something last went wrong, or right again, in its part of the fleet.
  int64_t second = -1;  // Which second these are of.
  uint64_t statements = 0;
  uint64_t appends = 0;
  uint64_t attempts = 0;
};

// What happens at a time. What happens at the same time happens in the order in which it was told.
template <typename World>
class Timeline {
 public:
  struct Facts {
    uint32_t a = 0;
    uint32_t b = 0;
    uint32_t c = 0;
    uint32_t d = 0;
    int64_t e = 0;
    int64_t f = 0;
  };
  using Happens = void (World::*)(const Facts& facts);

  Nanos now() const { return now_; }
  uint64_t events() const { return events_; }
  void At(Nanos time, Happens happens, const Facts& facts) {
    queue_.push({time, ++last_, happens, facts});
  }
  // Lets all happen until then.
  void Run(World& world, Nanos until) {
    while (!queue_.empty() && queue_.top().time <= until) {
      const Event event = queue_.top();
      queue_.pop();
      now_ = event.time;
      ++events_;
      (world.*event.happens)(event.facts);
    }
    now_ = until;
  }

 private:
  struct Event {
    Nanos time;
    uint64_t number;
    Happens happens;
    Facts facts;
    bool operator<(const Event& other) const {
      return time != other.time ? time > other.time : number > other.number;
    }
  };
  std::priority_queue<Event> queue_;
  Nanos now_ = 0;
  uint64_t last_ = 0;
  uint64_t events_ = 0;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_FLEET_WORLD_H_
