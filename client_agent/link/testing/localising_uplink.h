// Simulates a map store that takes the frames of robots that only localise, for tests.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_TESTING_LOCALISING_UPLINK_H_
#define CORBSLAM_CLIENT_AGENT_LINK_TESTING_LOCALISING_UPLINK_H_

#include <cstdint>
#include <map>
#include <vector>

#include "client_agent/link/testing/fake_uplink.h"

namespace corbslam::client_agent {

// A map store that takes the frames of such robots.
class LocalisingUplink : public FakeUplink {
 public:
  bool SendLocalised(const LocalisedFrames& said) override {
    if (!open || !takes) return false;
    bytes += 64 + 60 * said.frames.size() + 48 * said.tracked_frames.size() +
             8 * said.lost_frames_ns.size();
    localised.insert(localised.end(), said.frames.begin(), said.frames.end());
    ++messages;
    if (said.run == 0) return true;
    parts.push_back(said);
    if (!keeps_now) return true;
    std::vector<LocalisedFrames>& kept = runs[said.run];
    if (said.number == kept.size() + 1) kept.push_back(said);
    Keep({said.run, kept.size()});
    return true;
  }
  // Returns the times of the frames that are kept, lost ones below 0.
  std::vector<int64_t> Kept() const {
    std::vector<int64_t> times;
    for (const auto& [run, parts_of_run] : runs) {
      for (const LocalisedFrames& part : parts_of_run) {
        for (const TrackedFrame& frame : part.tracked_frames) times.push_back(frame.timestamp_ns);
        for (const int64_t time_ns : part.lost_frames_ns) times.push_back(-time_ns);
      }
    }
    return times;
  }
  std::map<uint64_t, std::vector<LocalisedFrames>> runs;
  std::vector<LocalisedFrames> parts;  // That came.
  bool keeps_now = true;
  bool takes = true;
  int messages = 0;
  std::vector<LocalisedFrame> localised;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_TESTING_LOCALISING_UPLINK_H_
