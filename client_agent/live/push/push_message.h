// Reads what drivers send to a push: source, and writes the answers (docs/push.md).
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_MESSAGE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_MESSAGE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/push_client/wire.h"
#include "client_agent/source/pose_listener.h"
#include "client_agent/source/rig/rig.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

// How pictures lie in a driver's memory: every slot holds both, wholly.
struct PushLayout {
  uint32_t slots = 0;
  uint64_t slot_bytes = 0;
  uint64_t memory_bytes = 0;
  push_wire::Picture first = {};
  push_wire::Picture second = {};
};

struct PushHello {
  PushLayout layout;
  std::string name;      // Printable, and may be empty.
  std::string rig_text;  // Empty: none.
};

struct PushFrame {
  uint32_t slot = 0;
  int64_t timestamp_ns = 0;
};

// INVALID_ARGUMENT names the field, its value and what it may be. Whatever the packet is, what is
// returned lies within `memory_bytes`; whether the memory has so many is not known here.
absl::StatusOr<PushHello> ParseHello(absl::string_view packet);
absl::StatusOr<PushFrame> ParseFrame(absl::string_view packet, const PushLayout& layout);
// Samples are in the order of time, from 0 to 2^62 ns, and finite.
absl::StatusOr<ImuSamples> ParseImu(absl::string_view packet);
// Returns whether a packet is to be parsed as an IMU's; any other is a frame's.
bool IsImu(absl::string_view packet);

// INVALID_ARGUMENT where these pictures can't be that rig's.
absl::Status CheckPictures(const PushLayout& layout, const Rig& rig);

std::string FormatWelcome(bool takes_imu);
std::string FormatSlotsFree(uint64_t slots);
// `pose` is taken as it is: the caller says of which camera it is to be.
std::string FormatPose(const FramePose& pose);
std::string FormatRefusal(absl::string_view why);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_MESSAGE_H_
