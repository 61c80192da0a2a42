// Records what a robot tracks, on a thread of its own, so that a failure can be sent in and played
// again (docs/recording.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_FRAME_RECORDER_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_FRAME_RECORDER_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/agent/agent.h"
#include "client_agent/agent/agent_orders.h"
#include "client_agent/tracking/tracking_result.h"
#include "services/programs/recording/recorded_lines.h"
#include "services/programs/recording/recording_files.h"
#include "services/programs/recording/recording_head.h"

namespace corbslam::services {

struct RecorderOptions {
  // Bytes of pictures that may wait for the disk.
  uint64_t max_waiting_bytes = 128 << 20;
  // Lines that may wait for it: a disk that takes nothing for longer ends the recording. Some
  // minutes of a camera, in a dozen megabytes.
  size_t max_waiting_lines = 10'000;
  // What stays free on the disk: the recording ends before.
  uint64_t least_free_bytes = 256 << 20;
  // True: tracking waits for the disk. False: frames for which there is no room are left out.
  bool waits = false;
  std::optional<double> rate_hz;  // Of the camera, for the rig file.
};

// Records one run. Pictures are kept, not copied: nobody may change them afterwards. The functions
// On... are called by the thread that tracks, and wait for nothing unless RecorderOptions::waits.
// When the disk fails or is full, that is logged once, the recording ends and the robot goes on.
class FrameRecorder {
 public:
  // Errors: the folder holds something, or can't be written.
  static absl::StatusOr<std::unique_ptr<FrameRecorder>> Start(const std::string& folder,
                                                              RecordingHead head,
                                                              const RecorderOptions& options);
  // Does what Finish does.
  ~FrameRecorder();
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  // Called before the agent begins a new local map because it was told to.
  void OnNewLocalMap();
  // Called before a frame is tracked, so that the frame that crashes a robot is recorded.
  void OnFrame(const SensorImages& images);
  // Called while it is tracked, with what other programs ordered before it.
  void OnOrders(const client_agent::OrdersForFrame& orders);
  // Called after it; `dropped` counts the frames so far that came too fast.
  void OnResult(const client_agent::TrackingResult& result, uint64_t dropped);

  // Writes what waits, and recording.json with all counts. Nothing is recorded afterwards. Returns
  // why the recording ended before, if it did.
  absl::Status Finish();

  // Returns an agent that does what `agent` does and tells this recorder of frames and local maps,
  // and of the orders that `agent` takes; those may be null. Neither is owned; the caller tells of
  // results.
  std::unique_ptr<client_agent::Agent> Watch(client_agent::Agent* agent,
                                             client_agent::AgentOrders* orders = nullptr);

 private:
  struct Item {
    RecordedLine line;
    std::optional<SensorImages> images;
    uint64_t bytes = 0;
    PictureMask mask = {};  // Of an OrdersLine.
    ImuSamples imu = {};    // Of a FrameLine: also where its pictures are left out.
  };
  FrameRecorder(RecordingHead head, std::unique_ptr<RecordingFiles> files,
                const RecorderOptions& options);
  void Run();
  absl::Status Write(const Item& item);
  void Fail(const Item& item, const absl::Status& why);
  // Queues an item, or ends the recording where it can't wait.
  void Push(Item item) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void EndBecause(const absl::Status& why) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TellLeftOut(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool HasRoom() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return waiting_bytes_ < options_.max_waiting_bytes || !failure_.ok();
  }
  bool HasSomething() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return !queue_.empty() || ending_;
  }

  const RecorderOptions options_;
  const bool has_imu_;
  const std::unique_ptr<RecordingFiles> files_;  // Of the thread alone, until it has ended.
  bool begins_local_map_ = false;                // Of the tracking thread, as the next one.
  uint64_t frame_ = 0;                           // Number of the frame that is tracked.

  absl::Mutex mutex_;
  RecordingHead head_ ABSL_GUARDED_BY(mutex_);
  std::deque<Item> queue_ ABSL_GUARDED_BY(mutex_);
  uint64_t waiting_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool ending_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
  absl::Time told_left_out_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_FRAME_RECORDER_H_
