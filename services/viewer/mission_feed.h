// Hands what a map store tells of one mission on to any number of browsers, each at its own pace.
#ifndef CORBSLAM_SERVICES_VIEWER_MISSION_FEED_H_
#define CORBSLAM_SERVICES_VIEWER_MISSION_FEED_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "corbslam/v1/viewer.pb.h"
#include "services/viewer/map_mirror.h"

namespace corbslam::services {

// An encoded v1::ViewerMessage, shared by all who are sent it; null: none.
using EncodedMessage = std::shared_ptr<const std::string>;

struct MissionFeedOptions {
  // Changes are kept up to so many bytes; who is farther behind begins with a new picture.
  size_t max_log_bytes = size_t{32} << 20;
  // Keyframes or points in a piece of a picture.
  size_t items_in_a_piece = 5000;
  // Events that a page is told when it comes.
  size_t max_events = 200;
};

// What one browser was told. Only MissionFeed looks into it.
struct FeedReader {
  bool with_points = true;

  uint64_t generation = 0;  // 0: nothing was told.
  PictureCursor picture = {};
  uint64_t next_change = 0;
  uint64_t next_event = 0;
  uint64_t pulse = 0;
  uint64_t sent_bytes = 0;
  uint32_t skips = 0;
};

// Follows one mission. Its memory is that of the map and of max_log_bytes, however many read and
// however slowly. Thread-safe; listeners are called without its lock.
class MissionFeed {
 public:
  explicit MissionFeed(const MissionFeedOptions& options = {}) : options_(options) {}

  // From the store.

  // Takes in a response of WatchMap; an error means that the stream must be begun anew.
  absl::Status Apply(v1::WatchMapResponse changes);
  // The next response begins the map anew: the stream to the store broke. What readers see stays
  // until it comes.
  void BeginAnew();
  void AddEvent(v1::MissionEvent event);
  // Returns the store's number of the last event; 0: none came.
  uint64_t newest_event() const;
  void SetPulse(v1::MissionPulse pulse);

  // To browsers.

  // Returns the next message for the reader; null: there is none now.
  EncodedMessage Next(FeedReader& reader) const;
  // The listener is called whenever Next may return a message. Returns a token that removes it.
  uint64_t AddListener(std::function<void()> listener);
  void RemoveListener(uint64_t token);
  size_t listeners() const;

 private:
  // A change, with and without points.
  struct Change {
    EncodedMessage whole;
    EncodedMessage without_points;
    size_t bytes() const { return whole->size() + without_points->size(); }
  };

  bool IsBehind(const FeedReader& reader) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  EncodedMessage BeginPicture(FeedReader& reader) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  EncodedMessage NextOfMap(FeedReader& reader) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  EncodedMessage NextEvent(FeedReader& reader) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  EncodedMessage NextPulse(FeedReader& reader) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  void TrimLog() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CallListeners() ABSL_LOCKS_EXCLUDED(mutex_);

  const MissionFeedOptions options_;
  mutable absl::Mutex mutex_;
  MapMirror mirror_ ABSL_GUARDED_BY(mutex_);
  // Grows when the map begins anew. 1: the first map; 0 is nobody's.
  uint64_t generation_ ABSL_GUARDED_BY(mutex_) = 1;
  bool begins_anew_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<Change> log_ ABSL_GUARDED_BY(mutex_);
  uint64_t log_begin_ ABSL_GUARDED_BY(mutex_) = 0;  // The number of the first change of the log.
  size_t log_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<EncodedMessage> events_ ABSL_GUARDED_BY(mutex_);
  uint64_t events_begin_ ABSL_GUARDED_BY(mutex_) = 1;
  uint64_t newest_event_ ABSL_GUARDED_BY(mutex_) = 0;
  v1::MissionPulse pulse_ ABSL_GUARDED_BY(mutex_);
  uint64_t pulses_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<uint64_t, std::function<void()>> listeners_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_token_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_MISSION_FEED_H_
