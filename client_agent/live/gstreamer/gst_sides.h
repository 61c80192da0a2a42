// Watches what the pipelines of a camera give: whether one of two ends alone, or all goes too fast.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SIDES_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SIDES_H_

#include <atomic>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client_agent/live/gstreamer/gst_camera.h"

namespace corbslam::client_agent {

// What a side gave since its pipeline was started; its streaming thread writes.
struct GstSide {
  std::atomic<uint64_t> pictures = 0;
  std::atomic<int64_t> first_ns = 0;
  std::atomic<int64_t> newest_ns = 0;
  std::atomic<bool> ended = false;

  void Add(int64_t time_ns) {
    if (pictures++ == 0) first_ns = time_ns;
    newest_ns = time_ns;
  }
  void Reset() {
    pictures = 0;
    first_ns = newest_ns = 0;
    ended = false;
  }
};

// Options and sides must outlive it. One thread asks.
class SideWatch {
 public:
  SideWatch(const GstCameraOptions& options, const GstSide& first, const GstSide& second)
      : options_(options), first_(first), second_(second), started_(absl::Now()) {}

  // Returns DATA_LOSS where one of two sides ended, and the other goes on for a second of its own
  // times, or gives nothing for five of ours and does not end.
  std::optional<absl::Status> OneSideEnded(absl::Time now);
  // At the end: says that one side gave other pictures than the other. Two recordings of one drive
  // have as many.
  void TellCounts() const;
  // Says once that a source that nobody holds back plays as fast as it can.
  void TellFast(absl::Time now);

 private:
  const GstCameraOptions& options_;
  const GstSide& first_;
  const GstSide& second_;
  const absl::Time started_;
  bool told_fast_ = false;
  // Of the side that goes on when the other has ended.
  uint64_t pictures_ = 0;
  absl::Time changed_ = absl::InfiniteFuture();
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SIDES_H_
