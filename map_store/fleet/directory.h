// What the directory of a database says of the stores that share its missions, and of the missions.
#ifndef CORBSLAM_MAP_STORE_FLEET_DIRECTORY_H_
#define CORBSLAM_MAP_STORE_FLEET_DIRECTORY_H_

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/time/time.h"

namespace corbslam::map_store {

// What an operator wants of a store. Drained, it also gives away the missions that it has.
enum class StoreDuty : int64_t { kTakesMissions = 0, kCordoned = 1, kDrained = 2 };

// How much a store has to do, as it says itself: of the last half minute, about.
struct StoreLoad {
  double busy_processors = 0;  // Processor seconds a second.
  double processors = 0;       // That its process may use.
  uint64_t resident_bytes = 0;
  uint64_t budget_bytes = 0;  // Beyond which it takes nothing in; 0: there is no limit.
  double keyframes_per_s = 0;

  // Returns the share that is used of processors or memory, whichever is shorter.
  double Pressure() const {
    const double busy = processors > 0 ? busy_processors / processors : 0;
    const double full =
        budget_bytes > 0 ? static_cast<double>(resident_bytes) / static_cast<double>(budget_bytes)
                         : 0;
    return std::max(busy, full);
  }
};

// What a mission is about to take of the store that has it.
struct MissionWeight {
  double busy_processors = 0;
  uint64_t bytes = 0;
};

// A store as the directory has it.
struct DirectoryStore {
  std::string name;     // The same one again after a restart.
  std::string address;  // HOST:PORT, as others reach it.
  std::string machine;
  std::string version;  // Of its program.
  // Until it counts as gone, unless it says again that it lives; by the journal's clock.
  absl::Duration lease_left = absl::ZeroDuration();
  // It takes no more missions, and, drained, gives away those that it has.
  bool is_cordoned = false;
  bool is_drained = false;
  bool is_own = false;    // This process's.
  uint64_t missions = 0;  // That it has.
  // Nullopt: it does not say, or has not for a minute.
  std::optional<StoreLoad> load = {};
  // Since a mission went from it or to it to balance loads.
  absl::Duration since_balanced = absl::InfiniteDuration();
  // HOST:PORT of the fusion workers that it offers to all, and how many of its requests wait.
  std::vector<std::string> workers = {};
  uint64_t waiting_requests = 0;

  bool IsAlive() const { return lease_left > absl::ZeroDuration(); }
};

// A mission as the directory has it.
struct DirectoryMission {
  std::string name;
  bool is_asleep = false;
  // Who has it, of which nobody takes it while `lease_left` is above 0. Asleep missions have none.
  std::string holder;
  std::string address;  // The holder's; empty: not known.
  bool is_own = false;  // This process's.
  int64_t epoch = 0;    // How often it was taken.
  absl::Duration lease_left = absl::ZeroDuration();
  // The store that is to have it, by its name, and its address while it is alive and takes any.
  std::string wanted = {};
  std::string wanted_address = {};
  uint64_t bytes = 0;
  std::string summary = {};  // Of one that is asleep (Journal::PutAside); empty: none is kept.

  bool IsHeldByAnother() const { return !is_own && lease_left > absl::ZeroDuration(); }
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FLEET_DIRECTORY_H_
