// Packets of a driver that is written by hand, for tests of what robots refuse.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_TESTING_PUSH_PACKETS_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_TESTING_PUSH_PACKETS_H_

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "client_agent/push_client/corbslam/push.h"
#include "client_agent/push_client/wire.h"

namespace corbslam::client_agent {

inline constexpr char kSmallRig[] =
    "rig: 1\nkind: stereo\ncameras:\n"
    "  - {size_px: [64, 48], focal_px: [40, 40], principal_px: [32, 24]}\n"
    "  - {size_px: [64, 48], focal_px: [40, 40], principal_px: [32, 24]}\n"
    "rectified: true\nbaseline_m: 0.1\n";

inline constexpr char kOneCameraRig[] =
    "rig: 1\nkind: monocular\ncameras:\n"
    "  - {size_px: [64, 48], focal_px: [40, 40], principal_px: [32, 24]}\n";

// Of the pair with an IMU, whose stamps are 2 ns too early.
inline std::string SmallRigWithImu() {
  return std::string(kSmallRig) +
         "imu: {imu_from_camera: [1, 0, 0, 0.05, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "
         "time_offset_s: 2.0e-9}\n";
}

template <typename Message>
std::string Bytes(const Message& message) {
  return {reinterpret_cast<const char*>(&message), sizeof(message)};
}

// Two grey pictures of 64x48 in each of two slots.
inline push_wire::Hello GoodHello() {
  push_wire::Hello hello = {};
  hello.header = {push_wire::kHello, sizeof(hello)};
  hello.magic = push_wire::kMagic;
  hello.version = push_wire::kVersion;
  hello.slots = 2;
  hello.slot_bytes = 8192;
  hello.memory_bytes = 16384;
  hello.first = {CORBSLAM_PUSH_GREY8, 64, 48, 64, 0};
  hello.second = {CORBSLAM_PUSH_GREY8, 64, 48, 64, 4096};
  std::strcpy(hello.name, "test");
  return hello;
}

// Says the sizes that follow from the rig's text.
inline std::string HelloPacket(push_wire::Hello hello, const std::string& rig = "") {
  hello.rig_bytes = static_cast<uint32_t>(rig.size());
  hello.header.bytes = static_cast<uint32_t>(sizeof(hello) + rig.size());
  return Bytes(hello) + rig;
}

inline std::string ImuPacket(const std::vector<push_wire::ImuSample>& samples) {
  push_wire::Imu head = {};
  head.header.kind = push_wire::kImu;
  head.header.bytes =
      static_cast<uint32_t>(sizeof(head) + samples.size() * sizeof(push_wire::ImuSample));
  head.samples = static_cast<uint32_t>(samples.size());
  std::string packet = Bytes(head);
  for (const push_wire::ImuSample& sample : samples) packet += Bytes(sample);
  return packet;
}

inline push_wire::Frame GoodFrame(uint32_t slot, int64_t timestamp_ns) {
  return {{push_wire::kFrame, sizeof(push_wire::Frame)}, slot, 0, timestamp_ns};
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_TESTING_PUSH_PACKETS_H_
