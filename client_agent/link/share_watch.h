// Tells from shared updates when the robot's local map joins others', and when it leaves them.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_SHARE_WATCH_H_
#define CORBSLAM_CLIENT_AGENT_LINK_SHARE_WATCH_H_

#include <functional>
#include <optional>

#include "slam/exchange/shared_update.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// What the link hears of the mission.
enum class LinkEvent {
  kMerged,          // The local map is in one frame with others, or with the mission's global one.
  kSplit,           // It is alone again, or not connected to the global frame any more.
  kMissionDeleted,  // The mission is no more, and the session has ended for good.
};
// Hears of events, with the local map in use; called on the uplink's threads, without locks.
using LinkEventListener = std::function<void(LinkEvent, LocalMapId)>;

// Watches the updates for one local map. Not thread-safe.
class ShareWatch {
 public:
  // Returns what the update means; nullopt: nothing new. An update that begins anew and goes on
  // later says nothing by itself: a session that begins again is told all again.
  std::optional<LinkEvent> Add(const SharedUpdate& update) {
    // Own keyframes are placed where there are others, and told first.
    const bool is_with_others = !update.own_keyframes.empty() || !update.keyframes.empty();
    if (!is_with_others) {
      if (!update.restart || update.more_places || !is_merged_) return std::nullopt;
      is_merged_ = false;
      return LinkEvent::kSplit;
    }
    const bool joins = !is_merged_ || (is_apart_ && !update.apart);
    const bool leaves = is_merged_ && !is_apart_ && update.apart;
    is_merged_ = true;
    is_apart_ = update.apart;
    if (joins) return LinkEvent::kMerged;
    return leaves ? std::optional(LinkEvent::kSplit) : std::nullopt;
  }

 private:
  bool is_merged_ = false;
  bool is_apart_ = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_SHARE_WATCH_H_
