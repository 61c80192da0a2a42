// Asks somebody who knows more of the mission than the robot where a frame was taken.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_PLACE_INQUIRY_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_PLACE_INQUIRY_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// Returns the camera's pose in the mission's global frame (x_in_camera = camera_from_global *
// x_in_global), or nullopt where nobody knows the place. Blocks for seconds at most. UNAVAILABLE,
// DEADLINE_EXCEEDED and RESOURCE_EXHAUSTED pass; after any other error nobody is asked again.
// Called on a thread of its own, by one caller at a time.
using AskPlace =
    std::function<absl::StatusOr<std::optional<Rigid3d>>(const KeyframePayload& frame)>;

struct PlaceQuestion {
  std::shared_ptr<const KeyframePayload> frame;
  LocalMapId local_map;
  // Where the frame was in that local map; nullopt: it was lost.
  std::optional<Rigid3d> camera_from_local;
};

struct PlaceAnswer {
  PlaceQuestion question;
  Rigid3d camera_from_global;
};

struct PlaceInquiryOptions {
  // Between an answer and the next question of a lost robot, and the first two of one that only
  // doesn't know where its local map lies; the latter doubles with each, whatever the answer is, up
  // to the longest.
  absl::Duration interval = absl::Milliseconds(200);
  absl::Duration longest_interval = absl::Seconds(5);
  // After an error that passes.
  absl::Duration patience = absl::Seconds(2);
  // The budget of the link upwards, of which questions take a quarter at most; 0: no bound.
  uint64_t uplink_bytes_per_second = 0;
  std::function<absl::Time()> clock = &absl::Now;
};

// One question is on its way at a time. Thread-safe.
class PlaceInquiry {
 public:
  // `ask` may be null: then nothing is asked. Without `threaded` a question is answered before Ask
  // returns.
  PlaceInquiry(AskPlace ask, const PlaceInquiryOptions& options, bool threaded);
  // Waits for the question that is on its way.
  ~PlaceInquiry();
  PlaceInquiry(const PlaceInquiry&) = delete;
  PlaceInquiry& operator=(const PlaceInquiry&) = delete;

  // Returns whether it is time for a question.
  bool MayAsk(bool is_lost) const;
  // Asks, if it is time for that.
  void Ask(PlaceQuestion question);
  // Another local map is in use, which nobody has asked of yet.
  void BeginLocalMap();
  // Returns, once only, the place that the last question got.
  std::optional<PlaceAnswer> TakeAnswer();

 private:
  void Run();
  void Answer(const PlaceQuestion& question);
  void Conclude(const PlaceQuestion& question, const absl::StatusOr<std::optional<Rigid3d>>& found);

  const AskPlace ask_;
  const PlaceInquiryOptions options_;
  mutable absl::Mutex mutex_;
  std::optional<PlaceQuestion> question_ ABSL_GUARDED_BY(mutex_);
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<PlaceAnswer> answer_ ABSL_GUARDED_BY(mutex_);
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  bool given_up_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time next_when_lost_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time next_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Duration interval_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_PLACE_INQUIRY_H_
