// Pushes the pictures of a stereo pair that moves along a wall, and prints the poses that come
// back:
//   client_agent --source push:/tmp/camera.sock &
//   push_wall /tmp/camera.sock 100
// In a driver of yours, what Paint does is the camera's work.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "corbslam/push.hpp"

namespace {

constexpr uint32_t kWidth = 640;
constexpr uint32_t kHeight = 360;
constexpr uint32_t kDisparity_px = 20;  // The wall is 400 * 0.1 / 20 = 2 m away.
constexpr uint32_t kStep_px = 4;        // To the right from frame to frame: 2 cm.
constexpr uint32_t kTile_px = 8;

constexpr char kRig[] = R"(rig: 1
kind: stereo
cameras:
  - {size_px: [640, 360], focal_px: [400, 400], principal_px: [320, 180]}
  - {size_px: [640, 360], focal_px: [400, 400], principal_px: [320, 180]}
rectified: true
baseline_m: 0.1
)";

// Grey of the wall's tile, at random but always the same.
uint8_t Grey(uint32_t column, uint32_t row) {
  uint32_t mixed = column * 2654435761u ^ row * 2246822519u;
  mixed ^= mixed >> 15;
  mixed *= 3266489917u;
  return static_cast<uint8_t>(mixed >> 24);
}

// Paints the wall from `left_px` on.
void Paint(uint32_t left_px, uint8_t* picture) {
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      picture[y * kWidth + x] = Grey((left_px + x) / kTile_px, y / kTile_px);
    }
  }
}

int64_t Now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Print(const corbslam_push_pose& pose) {
  if (pose.state != CORBSLAM_PUSH_TRACKING) {
    std::printf("%lld not tracked\n", static_cast<long long>(pose.timestamp_ns));
    return;
  }
  std::printf("%lld at %.3f %.3f %.3f m\n", static_cast<long long>(pose.timestamp_ns),
              pose.translation[0], pose.translation[1], pose.translation[2]);
}

void Run(const char* path, int frames) {
  corbslam_push_options options = {};
  options.socket_path = path;
  options.rig_text = kRig;
  options.name = "wall";
  options.first = {CORBSLAM_PUSH_GREY8, kWidth, kHeight, 0};
  options.second = options.first;
  options.timeout_ms = 30000;
  corbslam::PushConnection robot(options);
  for (int i = 0; i < frames; ++i) {
    // 50 ms without a free slot: the robot takes nothing at the moment, and misses this frame.
    if (const auto slot = robot.Begin(50); slot.has_value()) {
      const uint32_t left_px = 1000 + static_cast<uint32_t>(i) * kStep_px;
      Paint(left_px, static_cast<uint8_t*>(slot->first));
      Paint(left_px + kDisparity_px, static_cast<uint8_t*>(slot->second));
      robot.Commit(*slot, Now_ns());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    while (const auto pose = robot.NextPose(0)) Print(*pose);
  }
  // What is still being tracked.
  while (const auto pose = robot.NextPose(1000)) Print(*pose);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "push_wall SOCKET FRAMES\n");
    return 2;
  }
  try {
    Run(argv[1], std::atoi(argv[2]));
  } catch (const corbslam::PushError& error) {
    std::fprintf(stderr, "push_wall: %s\n", error.what());
    return 1;
  }
  return 0;
}
