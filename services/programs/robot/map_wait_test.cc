#include "services/programs/robot/map_wait.h"

#include <gtest/gtest.h>

#include <vector>

#include "absl/time/clock.h"

namespace corbslam::services {
namespace {

using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::TrackingResult;
using client_agent::TrajectoryPose;
using client_agent::UplinkHold;

// Its link is held for these reasons in turn, the last one for ever.
class HeldAgent : public client_agent::Agent {
 public:
  explicit HeldAgent(std::vector<UplinkHold> holds) : holds_(std::move(holds)) {}

  AgentStatus GetStatus() const override {
    AgentStatus status;
    status.upload.hold = holds_[std::min(asked, holds_.size() - 1)];
    ++asked;
    return status;
  }
  absl::StatusOr<TrackingResult> Track(const SensorImages&) override { return TrackingResult(); }
  absl::Status UsePause() override { return absl::OkStatus(); }
  void BeginLocalMap() override {}
  void Step() override {}
  absl::Status Finish(absl::Duration) override { return absl::OkStatus(); }
  AgentTimings GetTimings() const override { return {}; }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return {}; }
  Map CopyMap() const override { return {}; }
  std::optional<client_agent::NearMap> GetNearMap(
      const client_agent::NearMapLimits&) const override {
    return std::nullopt;
  }

  mutable size_t asked = 0;

 private:
  const std::vector<UplinkHold> holds_;
};

TEST(MapWaitTest, WaitsWhileAMissionWakes) {
  const HeldAgent agent({UplinkHold::kOpening, UplinkHold::kOpening, UplinkHold::kAway,
                         UplinkHold::kOpening, UplinkHold::kNone});
  const absl::Notification stop;
  WaitForMap(agent, "lab", stop);
  EXPECT_EQ(agent.asked, 5u);
}

TEST(MapWaitTest, DoesNotWaitForWhatWasRefused) {
  const HeldAgent agent({UplinkHold::kOpening, UplinkHold::kRefused});
  const absl::Notification stop;
  WaitForMap(agent, "lab", stop);
  EXPECT_EQ(agent.asked, 2u);
}

TEST(MapWaitTest, AStoreThatIsAwayIsNotWaitedForLong) {
  const HeldAgent agent({UplinkHold::kAway});
  const absl::Notification stop;
  const absl::Time begin = absl::Now();
  WaitForMap(agent, "lab", stop, {.away = absl::Milliseconds(100)});
  EXPECT_LT(absl::Now() - begin, absl::Seconds(5));
  EXPECT_GT(agent.asked, 1u);
}

TEST(MapWaitTest, WhoeverStopsTheRobotNeedNotWait) {
  const HeldAgent agent({UplinkHold::kOpening});
  absl::Notification stop;
  stop.Notify();
  WaitForMap(agent, "lab", stop);
  EXPECT_EQ(agent.asked, 1u);
}

}  // namespace
}  // namespace corbslam::services
