// Keeps who is connected to a mission, and what each robot has been told of it.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_SESSIONS_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_SESSIONS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/mission/event_book.h"
#include "map_store/mission/listeners.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/state/share_state.h"
#include "slam/exchange/shared_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Returns ABORTED if the session is not the agent's any more, or the mission is deleted.
absl::Status CheckSession(const MissionStrand& strand, uint64_t session_id,
                          const std::string& agent) ABSL_SHARED_LOCKS_REQUIRED(strand.mutex());

// Opens and closes sessions, and makes the shared updates of each. Thread-safe.
class MissionSessions {
 public:
  // The arguments are not owned and must outlive it.
  MissionSessions(MissionStrand& strand, EventBook& events) : strand_(strand), events_(events) {}

  // Opens a session and fences an older one of the agent, unless another process holds that.
  absl::StatusOr<SessionGrant> Open(uint64_t session_id, const SessionRequest& request);
  // `on_purpose`: the agent ended it itself.
  void Close(uint64_t session_id, const std::string& agent, bool on_purpose);
  // Keeps what a session's agent says of itself until it says something else; nothing is recorded.
  // Returns what CheckSession does.
  absl::Status NoteReport(uint64_t session_id, const std::string& agent, const AgentReport& report);

  absl::StatusOr<std::optional<SharedUpdate>> NextShared(uint64_t session_id,
                                                         const std::string& agent,
                                                         size_t byte_budget);
  // These do what MapStore::AskForExactPlaces and MapStore::TakeExactPlacesWanted say.
  absl::Status AskForExactPlaces(const std::string& agent);
  bool TakeExactPlacesWanted(const std::string& agent);

  // Says what agents reported and how they left, and of those that are connected what their
  // sessions were told.
  void DescribeTold(std::vector<AgentInfo>& agents) const;

  Listeners& listeners() { return listeners_; }
  const Listeners& listeners() const { return listeners_; }

 private:
  void DescribeTold(AgentInfo& agent) const ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  // Remembers what one agent was told. Its lock is taken before the state's lock; who tells the
  // agent more lets go of the state's lock now and then.
  struct Told {
    absl::Mutex mutex;
    ShareState share ABSL_GUARDED_BY(mutex);
    // True: somebody wants exact places, and the agent has not been asked for them yet.
    std::atomic<bool> exact_places_wanted = false;
    // Of its session: the updates that it was sent, whether it wants none (ShareMode::kNone), and
    // ShareState::complete_at_version after the last look.
    std::atomic<uint64_t> updates = 0;
    std::atomic<bool> wants_nothing = false;
    std::atomic<uint64_t> complete_at_version = 0;
    // What the agent last said of itself, and when; and how its last session ended.
    mutable absl::Mutex report_mutex;
    std::optional<AgentReport> report ABSL_GUARDED_BY(report_mutex);
    absl::Time report_came ABSL_GUARDED_BY(report_mutex);
    std::atomic<bool> left_on_purpose = false;
  };
  struct Opened {
    SessionGrant grant;
    uint64_t fenced = 0;  // The session whose place it took; 0: none.
    // Of the session's agent.
    Told* told = nullptr;
  };

  absl::Status CheckRequest(const SessionRequest& request) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  absl::StatusOr<Opened> Enter(uint64_t session_id, const SessionRequest& request);
  // Notes that the agent has joined, unless another session has taken this one's place already.
  void NoteJoined(uint64_t session_id, const std::string& agent) ABSL_LOCKS_EXCLUDED(coming_);
  // Ends the session, if it is still the agent's, and notes that the agent has left, if it was
  // said to have joined.
  void Leave(uint64_t session_id, const std::string& agent, bool has_joined, bool on_purpose)
      ABSL_LOCKS_EXCLUDED(coming_);
  // Notes which of others' local maps the agent goes without now, and did not before.
  void NoteContradictions(const std::string& agent, const std::optional<AgentReport>& before,
                          const AgentReport& now) ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  // Forgets what an agent was told that has ended, unless it has come again since.
  void ForgetTold(const std::string& agent);
  // Returns null if the agent never opened a session.
  Told* FindTold(const std::string& agent);
  // Returns the next update after one look at the state; nullopt: share.unfinished says whether to
  // look again.
  absl::StatusOr<std::optional<SharedUpdate>> PollUpdate(uint64_t session_id,
                                                         const std::string& agent,
                                                         size_t byte_budget,
                                                         ShareState& share) const;

  MissionStrand& strand_;
  EventBook& events_;
  Listeners listeners_;
  // Held while an agent is noted to have come or gone, so that events are in the order in which
  // sessions took each other's places. It is taken before the state's lock.
  absl::Mutex coming_;
  // What each agent was told, of all agents that ever had a session.
  std::map<std::string, Told> told_ ABSL_GUARDED_BY(strand_.mutex());
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_SESSIONS_H_
