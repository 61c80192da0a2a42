// Keeps what changed for a program that plans with the robot's pose: the newest 1,000 events.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_AGENT_EVENTS_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_AGENT_EVENTS_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client_agent/link/share_watch.h"
#include "client_agent/tracking/tracking_result.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

struct AgentEvent {
  enum class Kind {
    kLocalMapBegun,     // The first pose in a local map.
    kLost,              // Frames have no pose from here on.
    kRelocalised,       // The camera is found again in the same local map.
    kMapCorrected,      // The local map was moved as a whole, and the pose with it.
    kGlobalFrameMoved,  // global_from_local came, changed or went.
    kMerged,            // These three are LinkEvents.
    kSplit,
    kMissionDeleted,
    kEnded,  // No frame comes any more.
  };
  uint64_t number = 0;       // From 1 on, without gaps.
  absl::Time time;           // Of the robot's clock, when it was noted.
  int64_t timestamp_ns = 0;  // Of the newest frame then, in the camera's time; 0: there was none.
  Kind kind = Kind::kLost;
  LocalMapId local_map;
  // The epochs of the newest frame (TrackingResult::epoch); a link's event comes before the frame
  // that shows what it did.
  uint64_t epoch = 0;
  uint64_t global_epoch = 0;
};

// Thread-safe. Listeners are called one after the other, by whoever notes an event; they must
// return at once and may call After.
class AgentEvents {
 public:
  static constexpr size_t kMaxEvents = 1000;

  explicit AgentEvents(std::function<absl::Time()> clock = &absl::Now) : clock_(std::move(clock)) {}

  // Notes a frame, and what it changes. `global_epoch` counts the changes of the global frame's
  // place so far.
  void NoteFrame(const TrackingResult& result, uint64_t global_epoch);
  // Notes what a link heard. That a local map is merged before it has begun, with its first pose,
  // is an event once it has.
  void NoteLink(LinkEvent event, LocalMapId local_map);
  // Notes that no frame comes any more. What a link hears afterwards is noted all the same.
  void NoteEnd();

  // Returns the oldest event kept whose number is greater; nullopt if there is none. A number that
  // none has yet is of another process: the oldest of all is returned.
  std::optional<AgentEvent> After(uint64_t number) const;

  // Returns the number of the event that says so; nullopt while frames may come.
  std::optional<uint64_t> ended() const;

  // Returns a token for Remove. Once that returns, no call is under way and none follows.
  uint64_t AddListener(std::function<void()> listener);
  void RemoveListener(uint64_t token);

 private:
  using Kind = AgentEvent::Kind;
  // Returns what became of the pose; nullopt: nothing.
  std::optional<Kind> Judge(const TrackingResult& result) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Add(Kind kind, LocalMapId local_map) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns false for what is no event, or none yet.
  bool Begins(LinkEvent event, LocalMapId local_map) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CallListeners() ABSL_LOCKS_EXCLUDED(mutex_);

  const std::function<absl::Time()> clock_;

  mutable absl::Mutex mutex_;
  std::deque<AgentEvent> events_ ABSL_GUARDED_BY(mutex_);
  uint64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;
  TrackingResult newest_ ABSL_GUARDED_BY(mutex_);
  // The local map of the last frame that had a pose.
  LocalMapId last_tracked_ ABSL_GUARDED_BY(mutex_);
  // Local maps that had a pose, and one that is merged though it had none.
  std::set<LocalMapId> begun_ ABSL_GUARDED_BY(mutex_);
  std::optional<LocalMapId> merged_early_ ABSL_GUARDED_BY(mutex_);
  std::optional<uint64_t> ended_ ABSL_GUARDED_BY(mutex_);
  uint64_t global_epoch_ ABSL_GUARDED_BY(mutex_) = 0;

  // Taken without the other one.
  absl::Mutex listeners_mutex_;
  uint64_t last_token_ ABSL_GUARDED_BY(listeners_mutex_) = 0;
  std::map<uint64_t, std::function<void()>> listeners_ ABSL_GUARDED_BY(listeners_mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_AGENT_EVENTS_H_
