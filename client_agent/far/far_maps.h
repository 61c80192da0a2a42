// Brings parts of a robot's earlier local maps back into memory where the robot comes near them,
// or recognises a place of theirs, without a map store (docs/robot.md).
#ifndef CORBSLAM_CLIENT_AGENT_FAR_FAR_MAPS_H_
#define CORBSLAM_CLIENT_AGENT_FAR_FAR_MAPS_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/far/far_choice.h"
#include "client_agent/far/far_index.h"
#include "client_agent/far/far_share.h"
#include "client_agent/upload/spooled_map.h"
#include "slam/exchange/shared_update.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

struct FarMapsOptions {
  // Bytes that what was brought back may take, as EstimateBytes has it.
  uint64_t max_bytes = 0;
  // Bytes that may be taken by the bags of words of places that are not in memory.
  uint64_t max_bag_bytes = 0;
  // How far from the robot keyframes come back, in the local map's units.
  double radius = 50;
  // How long after a frame that was compared with the far places the next one is, in frames' time.
  int64_t recognise_every_ns = 500'000'000;
};

struct FarMapsStatus {
  size_t local_maps = 0;      // That have left memory and can come back.
  size_t keyframes = 0;       // Of them.
  uint64_t brought_back = 0;  // Keyframes, as often as they came.
  uint64_t reads = 0;         // Local maps read for that, as often as they were.
  uint64_t recognised = 0;    // Places that were recognised and not near.
  uint64_t unreadable = 0;    // Local maps that could not be read.
};

// A frame tells by this where the robot is.
struct FarFrame {
  int64_t timestamp_ns = 0;
  std::optional<Eigen::Vector3d> centre;  // In the local map in use; none: the robot is lost.
  std::shared_ptr<const KeyframePayload> payload;
};

// Thread-safe. Without Start it has no thread, and Step does its work. The work may wait for the
// disk, and is done without a lock.
class FarMaps {
 public:
  // Reads all that there is of a local map. Called by the work alone.
  using ReadLocalMap = std::function<absl::StatusOr<SpooledMap>(LocalMapId)>;
  // Takes an update for the local map; called by the work alone.
  using Share = std::function<void(LocalMapId for_local_map, SharedUpdate)>;
  using ComputeWords =
      std::function<std::shared_ptr<const Words>(const std::vector<Descriptor>& descriptors)>;

  FarMaps(const FarMapsOptions& options, ReadLocalMap read, Share share,
          ComputeWords compute_words);
  ~FarMaps();
  FarMaps(const FarMaps&) = delete;
  FarMaps& operator=(const FarMaps&) = delete;

  // Notes that a local map begins, which lies in the frame of the one before where `goes_on`. If it
  // doesn't, nobody knows where the earlier ones lie: they are forgotten (not on the disk).
  void BeginLocalMap(LocalMapId local_map, bool goes_on);
  // Notes that a local map, which has ended, leaves memory: `map` is as it is on the disk.
  void Keep(LocalMapId local_map, const Map& map);
  // Notes where the robot is. Costs next to nothing.
  void Note(const FarFrame& frame);

  void Start();
  // Ends the thread: nothing is read or shared any more.
  void Stop();
  // Works until there is nothing to do.
  void Step();
  FarMapsStatus status() const;

 private:
  struct Ended {
    LocalMapId local_map;
    std::vector<FarPlace> places;
    uint64_t bytes = 0;
  };
  struct News {
    std::optional<LocalMapId> begun;
    bool forget = false;
    std::vector<Ended> ended;
    std::optional<FarFrame> frame;
  };

  void Run();
  // Takes the news, if there is any or work is left, else returns false.
  bool Work();
  void Take(News& news);
  void Choose(const FarFrame& frame);
  // Returns a place that is not near, but looks like the frame's.
  std::optional<Eigen::Vector3d> Recognise(const FarFrame& frame);
  void Bring(LocalMapId local_map, const std::vector<KeyframeId>& ids);
  void NoteUnreadable(LocalMapId local_map, const absl::Status& why);
  void SendNext();

  const FarMapsOptions options_;
  const ReadLocalMap read_;
  const Share share_;
  const ComputeWords compute_words_;

  // Used by the work's thread alone.
  LocalMapId in_use_;
  FarIndex index_;
  FarChooser chooser_;
  FarShare told_;
  std::deque<SharedUpdate> to_send_;
  std::optional<Eigen::Vector3d> centre_;      // Where the robot was last.
  std::optional<Eigen::Vector3d> recognised_;  // Held for some frames.
  int recognised_for_ = 0;                     // So many comparisons more.
  std::optional<int64_t> compared_ns_;
  std::shared_ptr<const Words> compared_;
  bool choose_anew_ = false;

  mutable absl::Mutex mutex_;
  std::set<LocalMapId> in_frame_ ABSL_GUARDED_BY(mutex_);  // Local maps of the frame in use.
  News news_ ABSL_GUARDED_BY(mutex_);
  bool has_news_ ABSL_GUARDED_BY(mutex_) = false;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  FarMapsStatus status_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_FAR_FAR_MAPS_H_
