#include "services/programs/robot_flags.h"

#include <cstdio>
#include <utility>

#include "client_agent/live/live_sources.h"
#include "client_agent/source/source_kinds.h"
#include "services/convert/limits.h"

namespace corbslam::services {

using client_agent::ListSources;
using client_agent::SourceUsage;

namespace {

ChosenValue ChoosePosesOf(PosesOf* place) {
  return {[place](const std::string& name) -> std::string {
            const absl::StatusOr<PosesOf> poses_of = ParsePosesOf(name);
            if (!poses_of.ok()) return "must be one of camera, rectified, body";
            *place = *poses_of;
            return "";
          },
          std::string(ToString(*place)), "FRAME"};
}

void SayWhichSources() {
  std::printf("%s", ListSources().c_str());
  throw CLI::Success();
}

std::vector<Setting> SourceRows(RobotFlags& flags) {
  return {
      {"--source", &flags.source, SourceUsage() + ", with options: kitti:DIR?frames=0:120",
       kRequired},
      {"--rig", &flags.rig, "Rig file of the cameras, instead of the source's own"},
      {"--frames", &flags.frames, "First and last frame, A:B, as ?frames=", kRare},
      {"--server", &flags.server, "HOST:PORT of a map store; without: one robot alone"},
      {"--mission", &flags.mission, "The exploration that is shared"},
      {"--agent", &flags.agent, "This robot's name in it"},
      {"--pace", OneOf(kPaces, &flags.pace),
       "sensor: drop what comes too fast; max: wait; step: in lockstep"},
  };
}

std::vector<Setting> ResultRows(RobotFlags& flags) {
  return {
      {"--listen", &flags.listen, "HOST:PORT for other programs on the robot"},
      {"--stats", &flags.stats, "File to write statistics to, as JSON"},
      {"--held-map", &flags.held_map,
       "File for what the robot holds of its own and others' map in the end, for pictures", kRare},
      {"--told", &flags.told,
       "Beginning of two files of the poses that were told when each frame came, as TUM: "
       ".local.tum and .global.tum",
       kRare},
      {"--trajectory", &flags.trajectory,
       "File for the trajectory, as TUM; of further local maps: FILE.2 and so on"},
      {"--poses-of", ChoosePosesOf(&flags.poses_of),
       "Of --trajectory: camera (as recorded, the left one), rectified or body", kRare},
  };
}

std::vector<Setting> WorkRows(RobotFlags& flags) {
  return {
      {"--vocabulary", &flags.vocabulary, "File of the bag of words"},
      {"--seed", &flags.seed, "Of ids and random samples; 0: another one each time", kRare},
      {"--threads", &flags.solver_threads, "Solver threads", Within(1, 64)},
      {"--finish", &flags.finish_s,
       "Seconds to wait after the last frame until the map store has everything",
       RareWithin(0, 86400)},
      {"--outbox-mb", &flags.outbox_mb,
       "MiB that wait in memory, the rest waits in --spool alone; 0: everything does. With "
       "--memory-budget an eighth of it, unless said here",
       RareWithin(0, 1 << 20)},
      {"--downlink-kbps",
       &flags.downlink_kbps,
       "kbit/s of shared updates from it at most; 0: no bound",
       {.in = kLink_kbps, .unit = "KBPS"}},
      {"--localise-only", &flags.localise_only,
       "Map nothing: track the camera in what others mapped", kRare},
      {"--strict", &flags.strict,
       "Refuse a source in which something looks wrong, instead of warning"},
      {"--take-over", &flags.take_over,
       "Take the place of another process of this name that is connected"},
      {"--stay", &flags.stay, "At the end say \"finished\" and stay connected until SIGTERM"},
      {"--listen-insecure", &flags.listen_insecure,
       "Without TLS on --listen only, for a loopback address"},
  };
}

}  // namespace

int FeaturesOf(const RobotFlags& flags) {
  if (flags.features != 0) return flags.features;
  return flags.has_depth ? 1000 : 2000;
}

uint64_t OutboxBytesOf(const RobotFlags& flags) {
  return flags.given.contains("--outbox-mb") ? flags.outbox_mb << 20
                                             : OutboxBytesOf(flags.memory_budget_bytes);
}

MemoryNeeds MemoryNeedsOf(const RobotFlags& flags) {
  MemoryNeeds needs;
  // Before the source is open it may be an RGB-D camera's.
  needs.features = flags.features != 0 || flags.width_px > 0 ? FeaturesOf(flags) : 1000;
  needs.width_px = flags.width_px;
  needs.height_px = flags.height_px;
  needs.outbox_bytes = OutboxBytesOf(flags);
  return needs;
}

RobotFlags With(const SettableFlags& set, RobotFlags flags) {
  static_cast<SettableFlags&>(flags) = set;
  return flags;
}

bool IsBounded(const RobotFlags& flags) {
  return flags.memory_budget_bytes > 0 && !flags.server.empty();
}

SecurityOptions ListenSecurityOf(const RobotFlags& flags) {
  if (!flags.listen_insecure) return flags.security;
  SecurityOptions security;
  security.insecure = true;
  security.reflection = flags.security.reflection;
  security.health_is_open = flags.security.health_is_open;
  security.audit_file = flags.security.audit_file;
  security.audit_bytes = flags.security.audit_bytes;
  return security;
}

void AddRobotFlags(CLI::App& app, RobotFlags& flags) {
  // In the order in which --help shows them.
  AddSettings(app, SourceRows(flags));
  app.add_flag_callback("--sources", &SayWhichSources,
                        "Say what can be played and what each kind needs, and end");
  AddSettings(app, ResultRows(flags));
  AddSettings(app, RowsOf(static_cast<SettableFlags&>(flags)));
  AddSettings(app, WorkRows(flags));
  AddSpoolFlags(app, flags.spool);
  AddSettings(app, RowsOf(flags.settings));
  AddRecordFlags(app, flags.record);
  AddTlsFlags(app, flags.security);
  AddServerFlags(app, flags.security);
  AddClientFlags(app, flags.security);
  AddMetricsFlag(app, flags.observe);
}

}  // namespace corbslam::services
