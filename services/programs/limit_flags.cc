#include "services/programs/limit_flags.h"

#include <cstdint>
#include <type_traits>

#include "services/command_line/help_formatter.h"

namespace corbslam::services {

using map_store::MapStoreOptions;

namespace {

// No limit means more: nothing counts or weighs as much, or waits as long.
template <typename Value>
Value MostOf() {
  return std::is_floating_point_v<Value> ? Value(1e9) : Value(uint64_t{1} << 50);
}

template <typename Value>
void Add(CLI::App& app, const char* flag, Value& value, const char* what) {
  app.add_option(flag, value, what)
      ->check(CLI::Range(Value(0), MostOf<Value>()))
      ->capture_default_str()
      ->group(kRareGroup);
}

}  // namespace

void AddStoreLimitFlags(CLI::App& app, MapStoreOptions& options) {
  Add(app, "--max-missions", options.max_missions, "Missions in memory");
  Add(app, "--max-missions-asleep", options.max_missions_asleep, "Missions that are asleep");
  Add(app, "--max-agents", options.max_agents_per_mission, "Agents of a mission");
  Add(app, "--max-local-maps", options.max_local_maps_per_mission, "Local maps of a mission");
  Add(app, "--max-cameras", options.max_cameras_per_local_map, "Cameras of a local map");
  Add(app, "--max-features", options.max_keypoints_per_keyframe, "Features of a keyframe");
  Add(app, "--max-keyframe-bytes", options.max_keyframe_bytes, "Bytes of a keyframe's features");
  Add(app, "--max-batch-items", options.max_items_per_batch, "Items of a batch, without frames");
  Add(app, "--max-batch-frames", options.max_frames_per_batch,
      "Frames of a batch, tracked and lost ones");
  Add(app, "--max-batch-steps", options.max_pair_steps_per_batch,
      "Steps for pairs of keyframes and for parents that a batch takes");
  Add(app, "--max-agent-bytes", options.max_bytes_per_agent, "Bytes stored for one agent");
  Add(app, "--max-mission-bytes", options.max_bytes_per_mission, "Bytes stored for one mission");
  Add(app, "--max-picture-bytes", options.max_picture_bytes_per_mission,
      "Bytes of keyframes' pictures kept of a mission, the oldest go; 0: none");
  Add(app, "--max-backup-bytes", options.max_backup_bytes, "Bytes of a backup to be restored");
  Add(app, "--max-parked", options.max_parked_references,
      "References of a local map to what has not arrived");
  Add(app, "--max-parked-seconds", options.max_parked_s, "Seconds that they wait");
}

void AddStreamLimitFlags(CLI::App& app, StreamLimitOptions& options) {
  Add(app, "--max-streams", options.max_streams, "Open streams");
  Add(app, "--max-host-streams", options.max_streams_per_host, "Open streams from one host");
  Add(app, "--max-agent-streams", options.max_streams_per_agent, "Open streams of one agent");
  Add(app, "--max-message-bytes", options.max_message_bytes, "Bytes of one message of an agent");
  Add(app, "--max-batch-bytes", options.max_batch_bytes, "Bytes of a batch, all parts together");
  Add(app, "--max-unfinished-bytes", options.max_unfinished_bytes,
      "Bytes of all streams' unfinished batches");
  Add(app, "--open-timeout", options.open_timeout_s, "Seconds for a stream's first message");
  Add(app, "--part-timeout", options.part_timeout_s,
      "Seconds for the next part of a batch or backup");
  Add(app, "--max-waiting-calls", options.max_waiting_calls, "Calls that wait for a thread");
}

}  // namespace corbslam::services
