// Writes the snapshots that the journal wants, on a thread of its own.
#ifndef CORBSLAM_MAP_STORE_PROCESS_SNAPSHOT_KEEPER_H_
#define CORBSLAM_MAP_STORE_PROCESS_SNAPSHOT_KEEPER_H_

#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "map_store/process/mission.h"
#include "map_store/process/work_signal.h"

namespace corbslam::map_store {

// Writes one snapshot at a time, of whichever mission wants one. Thread-safe.
class SnapshotKeeper {
 public:
  // Lists missions for one round, which does not keep them in memory.
  using ListMissions = std::function<std::vector<std::weak_ptr<Mission>>()>;

  explicit SnapshotKeeper(std::function<absl::Time()> clock) : clock_(std::move(clock)) {}
  ~SnapshotKeeper() { Stop(); }

  // `when_written` is called after each snapshot.
  void Start(ListMissions missions, std::function<void()> when_written);
  // Gives up the snapshot that is being written, and joins the thread. The missions must still be
  // there.
  void Stop();
  // Tells the thread that something was written to a journal.
  void Wake() { signal_.Wake(); }

 private:
  void Run();

  const std::function<absl::Time()> clock_;
  ListMissions missions_;
  std::function<void()> when_written_;
  WorkSignal signal_;
  std::thread thread_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_SNAPSHOT_KEEPER_H_
