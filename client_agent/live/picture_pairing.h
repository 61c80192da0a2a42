// Makes frames of the pictures that cameras give whenever they like.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PICTURE_PAIRING_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PICTURE_PAIRING_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/live/stamp_watch.h"
#include "client_agent/source/frame_stream.h"

namespace corbslam::client_agent {

struct LivePicture {
  int64_t timestamp_ns = 0;
  cv::Mat image;
};

// The two pictures of a frame: left and right, or grey and depth. The second one is empty where the
// camera gives one alone.
struct LivePair {
  size_t number = 0;  // Counts the frames that the camera gave, taken or not, from 0.
  int drive = 0;      // As SourceFrame's: grows where times go on by another clock.
  LivePicture first;
  LivePicture second;
  std::chrono::steady_clock::time_point came;  // When the later of them came.
};

enum class LiveSide { kFirst, kSecond };

// Holds the newest pair alone: whoever is slower than the camera misses frames, and none waits.
// Thread-safe: cameras' threads push, one thread takes.
class PicturePairing {
 public:
  // `both`: a frame has two pictures, of times at most `within_ns` apart. The second side's were
  // taken `second_offset_ns` later than they are stamped, which is added to their times.
  PicturePairing(bool both, int64_t within_ns, int64_t second_offset_ns = 0)
      : both_(both), within_ns_(within_ns), second_offset_ns_(second_offset_ns) {}

  // Pictures of one side must come in the order of their times; others are counted and dropped, as
  // are those that another clock stamped (StampWatch). Where that clock stays, a new drive begins.
  void Push(LiveSide side, LivePicture picture) ABSL_LOCKS_EXCLUDED(mutex_);
  // Says that no more will come: OK at a recording's end, else why.
  void End(absl::Status status) ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits until `deadline` for the newest pair that was not taken yet; nullopt where there is none.
  // After the last pair: OUT_OF_RANGE, or the status that End was given.
  absl::StatusOr<std::optional<LivePair>> Take(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);
  CameraCounts counts() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  bool IsAnswerable() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return newest_.has_value() || ended_.has_value();
  }
  // Returns whether the picture is to be taken.
  bool Takes(LiveSide side, int64_t timestamp_ns) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Publish(LivePicture first, LivePicture second) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Drops the oldest picture of a side, which is `apart_ns` from the other side's oldest.
  void DropUnpaired(std::deque<LivePicture>& waiting, int64_t apart_ns)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Pairs the oldest waiting pictures, as far as both sides have some.
  void PairUp() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const bool both_;
  const int64_t within_ns_;
  const int64_t second_offset_ns_;
  mutable absl::Mutex mutex_;
  std::deque<LivePicture> waiting_[2] ABSL_GUARDED_BY(mutex_);
  StampWatch stamps_[2] ABSL_GUARDED_BY(mutex_);
  int drive_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<LivePair> newest_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::Status> ended_ ABSL_GUARDED_BY(mutex_);
  int64_t apart_sum_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  CameraCounts counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PICTURE_PAIRING_H_
