// The way of a keyframe from the camera to its global pose, as trace events.
#ifndef CORBSLAM_SERVICES_OBSERVE_TRACING_KEYFRAME_EVENTS_H_
#define CORBSLAM_SERVICES_OBSERVE_TRACING_KEYFRAME_EVENTS_H_

#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "slam/util/ids.h"

namespace corbslam {

// On the robot that made it: when its frame came from the camera; when the transport took it, with
// all that the store needs; when the store said that it is durable; when its global pose came back.
inline constexpr char kCaptured[] = "captured";
inline constexpr char kSent[] = "sent";
inline constexpr char kAcknowledged[] = "acknowledged";
inline constexpr char kGlobalPose[] = "global_pose";
// On another robot: when it came as a part of the shared map.
inline constexpr char kArrived[] = "arrived";
// In the store: when its batch was there; when that was durable; when fusion first placed it in an
// island, and when a global bundle adjustment first moved it; when it went to another robot.
inline constexpr char kReceived[] = "received";
inline constexpr char kDurable[] = "durable";
inline constexpr char kPlaced[] = "placed";
inline constexpr char kAdjusted[] = "adjusted";
inline constexpr char kShared[] = "shared";

// 32 hexadecimal digits, the same wherever the keyframe is known: the local map's id, then the
// keyframe's index in it. The form of a W3C trace id.
std::string TraceId(KeyframeId keyframe);

struct KeyframeEvent {
  absl::string_view name;  // One of the above.
  KeyframeId keyframe;
  absl::Time time;
  std::string mission;
  // The robot that it is about: who made it or, of kShared and kArrived, who gets it.
  std::string agent;
};

// One line without its end: an asynchronous instant of Chrome's trace event format. Lines of one
// keyframe have one global id, by which viewers put those of several files into one row.
std::string ToTraceLine(const KeyframeEvent& event, int process);
// The line that names a process.
std::string ProcessNameLine(absl::string_view name, int process);
// A number for the process: containers all have the same.
int ProcessNumber(absl::string_view name);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_OBSERVE_TRACING_KEYFRAME_EVENTS_H_
