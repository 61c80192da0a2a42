#include "client_agent/ros2/ros2_clock.h"

#include "absl/time/clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kNsOfSecond = 1'000'000'000;

}  // namespace

int64_t Nanoseconds(const builtin_interfaces_msg_dds__Time_& time) {
  return time.sec * kNsOfSecond + time.nanosec;
}

builtin_interfaces_msg_dds__Time_ Ros2Time(int64_t time_ns) {
  const int64_t rest = ((time_ns % kNsOfSecond) + kNsOfSecond) % kNsOfSecond;
  return {static_cast<int32_t>((time_ns - rest) / kNsOfSecond), static_cast<uint32_t>(rest)};
}

absl::StatusOr<std::unique_ptr<Ros2Clock>> Ros2Clock::Make(bool use_sim_time,
                                                           const Ros2Names& names, Ros2Node& node) {
  auto clock = std::make_unique<Ros2Clock>();
  if (!use_sim_time) return clock;
  ASSIGN_OR_RETURN(
      clock->subscription_,
      node.Subscribe(DdsTopic(names.Resolve("/clock")), rosgraph_msgs_msg_dds__Clock__desc,
                     {.reliable = false, .transient_local = false, .depth = 1},
                     [clock = clock.get()](const void* sample) {
                       clock->simulated_ns_ = Nanoseconds(
                           static_cast<const rosgraph_msgs_msg_dds__Clock_*>(sample)->clock);
                     }));
  return clock;
}

std::optional<int64_t> Ros2Clock::Now_ns() const {
  if (subscription_ == nullptr) return absl::GetCurrentTimeNanos();
  const int64_t now_ns = simulated_ns_;
  if (now_ns == kUnknown) return std::nullopt;
  return now_ns;
}

}  // namespace corbslam::client_agent
