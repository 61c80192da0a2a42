#include "client_agent/live/ros2/ros2_context.h"

#include <cstdlib>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Of the ports that DDS makes of it.
constexpr uint32_t kMostDomain = 232;

std::string Variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

Ros2Environment Ros2Environment::OfProcess() {
  return {Variable("ROS_DOMAIN_ID"), Variable("ROS_LOCALHOST_ONLY"),
          Variable("ROS_AUTOMATIC_DISCOVERY_RANGE"), Variable("ROS_DISTRO")};
}

absl::StatusOr<Ros2NodeOptions> MakeNodeOptions(const Ros2Environment& environment,
                                                const Ros2Names& names) {
  Ros2NodeOptions options;
  options.name = names.node();
  options.node_namespace = names.node_namespace();
  if (!environment.domain_id.empty() &&
      (!absl::SimpleAtoi(environment.domain_id, &options.domain) || options.domain > kMostDomain)) {
    return absl::InvalidArgumentError(absl::StrCat("ROS_DOMAIN_ID is '", environment.domain_id,
                                                   "', wants a number from 0 to ", kMostDomain));
  }
  const std::string& range = environment.discovery_range;
  if (range != "" && range != "LOCALHOST" && range != "SUBNET" && range != "SYSTEM_DEFAULT") {
    return absl::InvalidArgumentError(
        absl::StrCat("ROS_AUTOMATIC_DISCOVERY_RANGE is '", range,
                     "', known here are LOCALHOST, SUBNET and SYSTEM_DEFAULT"));
  }
  options.only_this_host = environment.localhost_only == "1" || range == "LOCALHOST";
  options.is_humble = environment.distro == "humble";
  return options;
}

void Ros2Context::Stop() {
  if (node_ != nullptr) node_->Stop();
}

absl::Status Ros2Context::Begin() {
  if (node_ != nullptr) return absl::OkStatus();
  ASSIGN_OR_RETURN(node_, Ros2Node::Create(options_));
  graph_ = std::make_unique<Ros2Graph>(*node_);
  ASSIGN_OR_RETURN(clock_, Ros2Clock::Make(settings_.use_sim_time, names_, *node_));
  ASSIGN_OR_RETURN(frames_, Ros2Frames::Make(names_, *node_));
  return absl::OkStatus();
}

void Ros2Context::SetCamera(Ros2CameraState state) {
  const absl::MutexLock lock(&mutex_);
  camera_ = std::move(state);
}

Ros2CameraState Ros2Context::camera() const {
  const absl::MutexLock lock(&mutex_);
  return camera_;
}

}  // namespace corbslam::client_agent
