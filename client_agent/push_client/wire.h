// The messages between a driver program and a robot's push: source, as bytes (docs/push.md).
//
// Both run on one machine: numbers have its byte order. Each message is one packet of a Unix socket
// of the type SOCK_SEQPACKET. Pictures lie in memory that the driver shares; messages name slots of
// it.
#ifndef CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_WIRE_H_
#define CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_WIRE_H_

#include <stdint.h>

#include <type_traits>

#include "client_agent/push_client/corbslam/push.h"

namespace corbslam::push_wire {

constexpr uint32_t kMagic = 0x48535550;  // "PUSH", as the bytes stand in memory.
constexpr uint32_t kVersion = 1;
constexpr uint32_t kMostSlots = 64;
constexpr uint32_t kMostRigBytes = 64 * 1024;
constexpr uint32_t kMostTextBytes = 2048;
constexpr uint32_t kNameBytes = 64;
// A frame's time is at most so far ahead of CLOCK_MONOTONIC: beyond, another clock made it.
constexpr int64_t kMostAhead_ns = int64_t{60} * 1'000'000'000;

constexpr uint32_t kMostImuSamples = 256;  // In one message.
constexpr uint32_t kTakesImu = 1;          // Of Welcome::takes.

// From the driver: kHello once, then kFrame and kImu. From the robot: kWelcome or kRefused, then
// the rest.
enum Kind : uint32_t {
  kHello = 1,
  kFrame = 2,
  kImu = 3,
  kWelcome = 101,
  kSlotsFree = 102,
  kPose = 103,
  kRefused = 104,
};

struct Header {
  uint32_t kind;
  uint32_t bytes;  // Of the whole message, which is the packet's size.
};

struct Picture {
  uint32_t format;  // corbslam_push_format of corbslam/push.h.
  uint32_t width_px;
  uint32_t height_px;
  uint32_t stride_bytes;
  uint64_t offset_bytes;  // From the slot's begin.
};

// The rig's text follows; the memory's file comes with it (SCM_RIGHTS).
struct Hello {
  Header header;
  uint32_t magic;
  uint32_t version;
  uint32_t slots;
  uint32_t rig_bytes;
  uint64_t slot_bytes;  // Slot i begins at i * slot_bytes.
  uint64_t memory_bytes;
  Picture first;          // Left, or that beside the depth.
  Picture second;         // Right, or depth; all 0: a frame has one picture.
  char name[kNameBytes];  // Of the driver, for the robot's log; ends with a zero.
};

struct Frame {
  Header header;
  uint32_t slot;
  uint32_t reserved;  // 0.
  int64_t timestamp_ns;
};

struct ImuSample {
  int64_t timestamp_ns;
  double angular_velocity_rps[3];
  double specific_force_mps2[3];
};

// `samples` times an ImuSample follows.
struct Imu {
  Header header;
  uint32_t samples;
  uint32_t reserved;  // 0.
};

struct Welcome {
  Header header;
  uint32_t version;
  uint32_t takes;  // Bits: what it takes beside frames. 0 from older robots.
};

struct SlotsFree {
  Header header;
  uint64_t slots;  // Bit i: slot i may be written again.
};

struct Pose {
  Header header;
  int64_t timestamp_ns;
  uint32_t state;  // corbslam_push_state.
  uint32_t points_matched;
  uint64_t local_map;
  uint64_t dropped;       // Frames so far that a newer one replaced before they were tracked.
  double translation[3];  // local_from_camera, metres; zero unless tracking.
  double rotation[4];     // Its unit quaternion: x, y, z, w.
};

// A text of at most kMostTextBytes follows. It is the last message.
struct Refused {
  Header header;
};

static_assert(sizeof(Header) == 8 && sizeof(Picture) == 24 && sizeof(Hello) == 152);
static_assert(sizeof(Frame) == 24 && sizeof(Welcome) == 16 && sizeof(SlotsFree) == 16);
static_assert(sizeof(ImuSample) == 56 && sizeof(Imu) == 16);
static_assert(sizeof(Pose) == 96 && sizeof(Refused) == 8);
static_assert(std::is_trivially_copyable_v<Hello> && std::is_trivially_copyable_v<Pose>);

// Returns how many bytes a pixel of a format has; 0: there is no such format.
inline uint32_t BytesPerPixel(uint32_t format) {
  switch (format) {
    case CORBSLAM_PUSH_GREY8:
      return 1;
    case CORBSLAM_PUSH_GREY16:
    case CORBSLAM_PUSH_DEPTH16:
      return 2;
    case CORBSLAM_PUSH_BGR8:
      return 3;
    default:
      return 0;
  }
}

}  // namespace corbslam::push_wire

#endif  // CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_WIRE_H_
