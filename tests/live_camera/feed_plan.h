// Says when a feeder gives which frame of a recording, and what goes wrong on the way.
#ifndef CORBSLAM_TESTS_LIVE_CAMERA_FEED_PLAN_H_
#define CORBSLAM_TESTS_LIVE_CAMERA_FEED_PLAN_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace corbslam::tests {

struct FeedOptions {
  uint64_t seed = 1;
  // Shares of the frames; no frame suffers twice.
  double dropped = 0;
  double late = 0;
  double doubled = 0;
  double late_s = 0.08;  // How much later than it was taken a late frame is given, at most.
  // The camera is gone from unplug_at_s on for unplug_s; 0: never.
  double unplug_at_s = 0;
  double unplug_s = 0;
  // True: the world stands still meanwhile, so that the next frame comes behind the pause. False:
  // the frames of that time are never seen.
  bool hold = false;
};

// INVALID_ARGUMENT names the field, its value and its limits.
absl::Status Validate(const FeedOptions& options);

struct FedFrame {
  size_t frame = 0;      // Index of the recording's frame.
  double given_s = 0;    // Since the start; never falls from frame to frame.
  double stamped_s = 0;  // Since the start: when it was taken.
};

struct FeedPlan {
  std::vector<FedFrame> frames;
  size_t dropped = 0;
  size_t late = 0;
  size_t doubled = 0;
  size_t unseen = 0;  // Taken while nobody was plugged in.
};

// `taken_s` are the times of the recording's frames, from 0 on. The same options give the same
// plan.
FeedPlan MakeFeedPlan(const std::vector<double>& taken_s, const FeedOptions& options);

// Returns "120 frames, of them 9 late and 4 doubled; 12 dropped, 0 unseen".
std::string Describe(const FeedPlan& plan);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_LIVE_CAMERA_FEED_PLAN_H_
