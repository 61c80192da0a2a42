// Says what a robot plays: the frames of a camera, one after the other as they come.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_STREAM_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_STREAM_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client_agent/source/pose_listener.h"
#include "client_agent/source/source_finding.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

struct SourceFrame {
  size_t number = 0;         // Counts in the whole sequence or since the camera was opened, from 0.
  int64_t timestamp_ns = 0;  // The source's own time.
  // Frames of one drive have growing times (FrameReader::drive). Between frames of two drives
  // nobody knows how the camera got there.
  int drive = 0;
};

// Frames that could not be read and were left out.
struct LeftOutFrames {
  size_t count = 0;
  std::string last;  // Why the last of them was left out.
};

// How the pictures of a live camera came since it was opened.
struct CameraCounts {
  uint64_t frames = 0;     // Those that came whole, taken or not.
  uint64_t overtaken = 0;  // Frames that a newer one replaced before they were taken.
  uint64_t unpaired = 0;   // Pictures without a counterpart in time.
  // Of each side, pictures that came whole or not; and how near to each other two pictures without
  // counterpart were at best, 0 where there were none of both sides.
  uint64_t pictures[2] = {0, 0};
  int64_t nearest_unpaired_ns = 0;
  uint64_t late = 0;  // Pictures that came behind a newer one, or had its very time.
  // Pictures that were stamped further ahead of the one before than time had passed.
  uint64_t ahead = 0;
  // How much later the second picture of a frame was taken than the first: mean with its sign, and
  // the largest either way.
  int64_t mean_apart_ns = 0;
  int64_t most_apart_ns = 0;
};

struct StreamFrame {
  SourceFrame frame;
  SensorImages images;  // They are stamped with the frame's time.
  // When a camera gave it; a recording's frames come when they are asked for.
  std::optional<std::chrono::steady_clock::time_point> came = {};
};
struct NoFrameYet {};  // No frame came before the deadline; the stream goes on.
struct StreamEnd {};   // No frame follows.
using NextFrame = std::variant<StreamFrame, NoFrameYet, StreamEnd>;

// Gives each frame once. How many there will be is not known, nor when the next one is taken; a
// caller that needs to know takes a RecordedSequence. Not thread-safe, though an implementation may
// read ahead on a thread of its own. Times need not grow (a sequence may be played backwards), so
// that nobody may take the differences of times to be positive.
class FrameStream {
 public:
  virtual ~FrameStream() = default;

  // The calibration also says in which frames poses can be given (RecordedCameraOf).
  virtual const SensorCalibration& calibration() const = 0;
  // Returns the seconds from frame to frame, where that is known before they come.
  virtual std::optional<double> interval_s() const = 0;
  // Waits until `deadline` for the next frame; with a deadline that has passed it asks whether one
  // is there already. An error names the frame and is the stream's last word: after it, as after
  // StreamEnd, there is StreamEnd. A frame that can't be read may be left out instead.
  virtual absl::StatusOr<NextFrame> Next(absl::Time deadline) = 0;
  // Returns the frames that were left out so far.
  virtual LeftOutFrames left_out() const = 0;
  // Returns how many frames a newer one replaced before they were taken: a camera's, whose frames
  // do not wait.
  virtual uint64_t overtaken() const { return 0; }
  // Returns what looked wrong so far in how the camera gives its pictures, or in what they show; it
  // was logged when it was found.
  virtual SourceFindings findings() const { return {}; }
  // Nullopt: the stream is of no live camera.
  virtual std::optional<CameraCounts> camera_counts() const { return std::nullopt; }
  // Returns who wants to hear what became of the stream's frames, and lives as long as the stream;
  // null: nobody.
  virtual PoseListener* pose_listener() { return nullptr; }
  // Returns false where the stream makes each frame when it is asked, whatever the frame's time is:
  // then it may be too slow for its own times. True: frames come by themselves, as a camera's do.
  virtual bool is_live() const { return true; }
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_STREAM_H_
