#include "services/programs/limit_flags.h"

#include "services/command_line/setting.h"

namespace corbslam::services {

using map_store::MapStoreOptions;

namespace {

// No limit means more: nothing counts or weighs as much.
constexpr SettingForm kCount = {.in = {0, double{uint64_t{1} << 50}}, .rare = true};
constexpr SettingForm kSeconds = RareWithin(0, 1e9);

}  // namespace

void AddStoreLimitFlags(CLI::App& app, MapStoreOptions& options) {
  AddSettings(
      app,
      {
          {"--max-missions", &options.max_missions, "Missions in memory", kCount},
          {"--max-missions-asleep", &options.max_missions_asleep, "Missions that are asleep",
           kCount},
          {"--max-agents", &options.max_agents_per_mission, "Agents of a mission", kCount},
          {"--max-local-maps", &options.max_local_maps_per_mission, "Local maps of a mission",
           kCount},
          {"--max-cameras", &options.max_cameras_per_local_map, "Cameras of a local map", kCount},
          {"--max-features", &options.max_keypoints_per_keyframe, "Features of a keyframe", kCount},
          {"--max-keyframe-bytes", &options.max_keyframe_bytes, "Bytes of a keyframe's features",
           kCount},
          {"--max-batch-items", &options.max_items_per_batch, "Items of a batch, without frames",
           kCount},
          {"--max-batch-frames", &options.max_frames_per_batch,
           "Frames of a batch, tracked and lost ones", kCount},
          {"--max-batch-steps", &options.max_pair_steps_per_batch,
           "Steps for pairs of keyframes and for parents that a batch takes", kCount},
          {"--max-agent-bytes", &options.max_bytes_per_agent, "Bytes stored for one agent", kCount},
          {"--max-mission-bytes", &options.max_bytes_per_mission, "Bytes stored for one mission",
           kCount},
          {"--max-picture-bytes", &options.max_picture_bytes_per_mission,
           "Bytes of keyframes' pictures kept of a mission, the oldest go; 0: none", kCount},
          {"--max-backup-bytes", &options.max_backup_bytes, "Bytes of a backup to be restored",
           kCount},
          {"--max-parked", &options.max_parked_references,
           "References of a local map to what has not arrived", kCount},
          {"--max-parked-seconds", &options.max_parked_s, "Seconds that they wait", kSeconds},
      });
}

void AddStreamLimitFlags(CLI::App& app, StreamLimitOptions& options) {
  AddSettings(app, {
                       {"--max-streams", &options.max_streams, "Open streams", kCount},
                       {"--max-host-streams", &options.max_streams_per_host,
                        "Open streams from one host", kCount},
                       {"--max-agent-streams", &options.max_streams_per_agent,
                        "Open streams of one agent", kCount},
                       {"--max-message-bytes", &options.max_message_bytes,
                        "Bytes of one message of an agent", kCount},
                       {"--max-batch-bytes", &options.max_batch_bytes,
                        "Bytes of a batch, all parts together", kCount},
                       {"--max-unfinished-bytes", &options.max_unfinished_bytes,
                        "Bytes of all streams' unfinished batches", kCount},
                       {"--open-timeout", &options.open_timeout_s,
                        "Seconds for a stream's first message", kSeconds},
                       {"--part-timeout", &options.part_timeout_s,
                        "Seconds for the next part of a batch or backup", kSeconds},
                       {"--max-waiting-calls", &options.max_waiting_calls,
                        "Calls that wait for a thread", kCount},
                   });
}

}  // namespace corbslam::services
