// Writes the way of a keyframe from the camera to its global pose as trace events.
#ifndef CORBSLAM_SERVICES_OBSERVE_TRACING_KEYFRAME_EVENTS_H_
#define CORBSLAM_SERVICES_OBSERVE_TRACING_KEYFRAME_EVENTS_H_

#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Events on the robot that made the keyframe: its frame came from the camera; the transport took
// the keyframe, with all that the store needs; the store said that it is durable; its global pose
// came back.
inline constexpr char kCaptured[] = "captured";
inline constexpr char kSent[] = "sent";
inline constexpr char kAcknowledged[] = "acknowledged";
inline constexpr char kGlobalPose[] = "global_pose";
// Event on another robot: the keyframe came as a part of the shared map.
inline constexpr char kArrived[] = "arrived";
// Events in the store: the keyframe's batch was there; the batch was durable; fusion first placed
// the keyframe in an island; a global bundle adjustment first moved it; it went to another robot.
inline constexpr char kReceived[] = "received";
inline constexpr char kDurable[] = "durable";
inline constexpr char kPlaced[] = "placed";
inline constexpr char kAdjusted[] = "adjusted";
inline constexpr char kShared[] = "shared";

// Returns 32 hexadecimal digits, the same wherever the keyframe is known: the local map's id, then
// the keyframe's index in it. They have the form of a W3C trace id.
std::string TraceId(KeyframeId keyframe);

struct KeyframeEvent {
  absl::string_view name;  // One of the names above.
  KeyframeId keyframe;
  absl::Time time;
  std::string mission;
  // The robot that made the keyframe or, for kShared and kArrived, the one that gets it.
  std::string agent;
};

// Returns one line without its end: an asynchronous instant of Chrome's trace event format. Lines
// of one keyframe have one global id, by which viewers put those of several files into one row.
std::string ToTraceLine(const KeyframeEvent& event, int process);
// Returns the line that names a process.
std::string ProcessNameLine(absl::string_view name, int process);
// Returns a number made of the process's name: process ids are the same in all containers.
int ProcessNumber(absl::string_view name);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_TRACING_KEYFRAME_EVENTS_H_
