// SingleAgent's part that, without a map store, brings far parts of its map back from the spool.
#include <limits>
#include <utility>

#include "client_agent/agent/single_agent.h"

namespace corbslam::client_agent {
namespace {

// Shares of AgentOptions::max_map_bytes: what comes back is a part of the map that is bounded, what
// far places look like comes to it.
constexpr uint64_t kForWhatComesBack = 4;
constexpr uint64_t kForBags = 8;

}  // namespace

std::unique_ptr<FarMaps> SingleAgent::MakeFarMaps(bool has_uplink) {
  // Without an uplink there is a bound only where there is a spool (CheckParts).
  if (options_.max_map_bytes == 0 || has_uplink) return nullptr;
  FarMapsOptions options;
  options.max_bytes = options_.max_map_bytes / kForWhatComesBack;
  options.max_bag_bytes = options_.max_map_bytes / kForBags;
  // Without a scale there are no metres, and the number of keyframes alone is the bound.
  options.radius =
      camera_->IsMetric() ? options_.share.radius_m : std::numeric_limits<double>::infinity();
  return std::make_unique<FarMaps>(
      options, [this](LocalMapId local_map) { return link_->ReadTold(local_map); },
      [this](LocalMapId local_map, SharedUpdate update) {
        link_->Share(local_map, std::move(update));
      },
      [vocabulary = vocabulary_](const std::vector<Descriptor>& descriptors) {
        return std::make_shared<const Words>(vocabulary->Transform(descriptors));
      });
}

void SingleAgent::KeepForReturn(const LocalMapSession& session) const {
  if (far_ == nullptr) return;
  session.map().Read([&](const Map& map) { far_->Keep(session.map().local_map(), map); });
}

void SingleAgent::LookForFar(const TrackingResult& result) const {
  if (far_ == nullptr) return;
  FarFrame frame;
  frame.timestamp_ns = result.timestamp_ns;
  if (result.state == TrackingState::kTracking)
    frame.centre = CameraCentre(result.camera_from_local);
  // What is recognised is recognised by features.
  if (!result.was_followed) frame.payload = current().tracker().last_payload();
  far_->Note(frame);
}

}  // namespace corbslam::client_agent
