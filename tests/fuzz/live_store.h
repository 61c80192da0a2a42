// Makes a map store as fuzzers use it.
#ifndef CORBSLAM_TESTS_FUZZ_LIVE_STORE_H_
#define CORBSLAM_TESTS_FUZZ_LIVE_STORE_H_

#include <memory>
#include <utility>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"

namespace corbslam::tests {

// The store has no threads, and low limits, so that inputs of a few kB reach them.
inline map_store::MapStoreOptions LiveStoreOptions() {
  map_store::MapStoreOptions options;
  options.deterministic = true;
  options.max_missions = 2;
  options.max_agents_per_mission = 3;
  options.max_local_maps_per_mission = 4;
  options.max_parked_references = 20;
  options.max_keyframe_bytes = 100000;
  options.max_bytes_per_agent = 1 << 20;
  options.settle_after = 1;
  return options;
}

// Makes a store without a worker, on a journal of bytes.
inline std::unique_ptr<map_store::MapStore> MakeLiveStore(
    std::shared_ptr<testing::JournalBytes> bytes = std::make_shared<testing::JournalBytes>()) {
  return std::make_unique<map_store::MapStore>(
      LiveStoreOptions(), nullptr, std::make_unique<testing::ByteJournal>(std::move(bytes)),
      nullptr, [] { return absl::UnixEpoch(); });
}

// Makes every look-up, and everything that is shared with another agent.
inline void LookAtEverything(map_store::MapStore& store) {
  const auto missions = store.ListMissions({});
  if (!missions.ok()) return;
  for (const map_store::MissionInfo& mission : missions->items) {
    store.RunFusionUntilIdle(mission.name).IgnoreError();
    (void)store.GlobalMapView(mission.name);
    map_store::MapWatcher watcher(0, true);
    (void)store.NextChanges(mission.name, 1000, watcher);
    (void)store.ReplayMap(mission.name, {.include_points = true}, [] { return true; });
    (void)store.EventAfter(mission.name, 0);
    (void)store.GetStatistics(mission.name);
    (void)store.ListAgents(mission.name, {});
    (void)store.ListLocalMaps(mission.name, {});
    (void)store.ListKeyframes(mission.name, {}, {});
    (void)store.GetTrajectory(mission.name, "", map_store::TrajectoryFrame::kLocal);
    (void)store.GetTrajectory(mission.name, "", map_store::TrajectoryFrame::kGlobal, true);
    SessionRequest request;
    request.mission = mission.name;
    request.agent = "onlooker";
    const auto opened = store.OpenSession(request);
    if (!opened.ok()) continue;
    for (int i = 0; i < 100; ++i) {
      const auto update = store.NextShared(opened->session_id, 10000);
      if (!update.ok() || !update->has_value()) break;
    }
  }
}

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FUZZ_LIVE_STORE_H_
