#include "services/programs/robot_flags.h"

#include <cstdio>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client_agent/live/live_sources.h"
#include "client_agent/source/source_kinds.h"
#include "services/command_line/help_formatter.h"
#include "services/command_line/values.h"
#include "services/programs/link_flags.h"
#include "services/programs/memory_flags.h"
#include "services/programs/share_flags.h"
#include "slam/features/feature_limits.h"

namespace corbslam::services {

using client_agent::ListSources;
using client_agent::SourceUsage;

namespace {

void AddSource(CLI::App& app, RobotFlags& flags) {
  app.add_option("--source", flags.source, SourceUsage() + ", with options: kitti:DIR?frames=0:120")
      ->required();
  app.add_flag_callback(
      "--sources",
      [] {
        std::printf("%s", ListSources().c_str());
        throw CLI::Success();
      },
      "Say what can be played and what each kind needs, and end");
  app.add_option("--rig", flags.rig, "Rig file of the cameras, instead of the source's own");
  app.add_option("--frames", flags.frames, "First and last frame, A:B, as ?frames=")
      ->group(kRareGroup);
}

void AddMission(CLI::App& app, RobotFlags& flags) {
  app.add_option("--server", flags.server, "HOST:PORT of a map store; without: one robot alone");
  app.add_option("--mission", flags.mission, "The exploration that is shared")
      ->capture_default_str();
  app.add_option("--agent", flags.agent, "This robot's name in it")->capture_default_str();
}

void AddPace(CLI::App& app, RobotFlags& flags) {
  app.add_option("--pace", flags.pace,
                 "sensor: drop what comes too fast; max: wait; step: in lockstep")
      ->transform(Choice({{"sensor", static_cast<int>(Pace::kSensor)},
                          {"max", static_cast<int>(Pace::kMax)},
                          {"step", static_cast<int>(Pace::kStep)}}))
      ->type_name("max|sensor|step")
      ->default_str("max");
}

void AddResults(CLI::App& app, RobotFlags& flags) {
  app.add_option("--listen", flags.listen, "HOST:PORT for other programs on the robot");
  app.add_option("--stats", flags.stats, "File to write statistics to, as JSON");
  app.add_option(
         "--held-map", flags.held_map,
         "File for what the robot holds of its own and others' map in the end, for pictures")
      ->group(kRareGroup);
  app.add_option("--told", flags.told,
                 "Beginning of two files of the poses that were told when each frame came, as TUM: "
                 ".local.tum and .global.tum")
      ->group(kRareGroup);
  app.add_option("--trajectory", flags.trajectory,
                 "File for the trajectory, as TUM; of further local maps: FILE.2 and so on");
  app.add_option("--poses-of", flags.poses_of,
                 "Of --trajectory: camera (as recorded, the left one), rectified or body")
      ->transform(Choice({{"camera", static_cast<int>(PosesOf::kRecordedCamera)},
                          {"rectified", static_cast<int>(PosesOf::kRectifiedCamera)},
                          {"body", static_cast<int>(PosesOf::kBody)}}))
      ->type_name("FRAME")
      ->default_str("camera")
      ->group(kRareGroup);
}

// Returns what is wrong with the value; empty if it is good.
std::string CheckFeatures(const std::string& text) {
  int features = 0;
  const bool good = absl::SimpleAtoi(text, &features) &&
                    (features == 0 || (features >= kLeastFeatures && features <= kMostFeatures));
  if (good) return "";
  return absl::StrCat("\"", text, "\" is neither 0 nor a whole number from ", kLeastFeatures,
                      " to ", kMostFeatures);
}

void AddWork(CLI::App& app, RobotFlags& flags) {
  app.add_option("--vocabulary", flags.vocabulary, "File of the bag of words")
      ->capture_default_str();
  app.add_option("--features", flags.features,
                 "Features of a picture; 0: 2000 for stereo, 1000 for RGB-D")
      ->check(CLI::Validator(&CheckFeatures, ""))
      ->capture_default_str();
  app.add_option("--seed", flags.seed, "Of ids and random samples; 0: another one each time")
      ->capture_default_str()
      ->group(kRareGroup);
  app.add_option("--threads", flags.solver_threads, "Solver threads")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--finish", flags.finish_s,
                 "Seconds to wait after the last frame until the map store has everything")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str()
      ->group(kRareGroup);
}

}  // namespace

int FeaturesOf(const RobotFlags& flags) {
  if (flags.features != 0) return flags.features;
  return flags.has_depth ? 1000 : 2000;
}

uint64_t OutboxBytesOf(const RobotFlags& flags) {
  return flags.given.contains("--outbox-mb") ? flags.outbox_mb << 20 : OutboxBytesOf(flags.memory);
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

ShareFlags ShareOf(const RobotFlags& flags) {
  const bool is_bounded = flags.memory.budget_bytes > 0 && !flags.server.empty();
  return is_bounded ? WithBoundedMemory(flags.share) : flags.share;
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
  AddSource(app, flags);
  AddMission(app, flags);
  AddPace(app, flags);
  AddResults(app, flags);
  AddWork(app, flags);
  AddSpoolFlags(app, flags.spool);
  app.add_option("--outbox-mb", flags.outbox_mb,
                 "MiB that wait in memory, the rest waits in --spool alone; 0: everything does. "
                 "With --memory-budget an eighth of it, unless said here")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str()
      ->group(kRareGroup);
  app.add_option(
         "--upload", flags.upload,
         "Of each keyframe: features=all, =mapped or =N; &picture=N: with one for people, N px "
         "wide; 0: none")
      ->capture_default_str();
  AddLinkFlags(app, flags.link);
  AddShareFlags(app, flags.share);
  AddMemoryFlags(app, flags.memory);
  AddSettingsFlags(app, flags.settings, flags.max_rate_hz);
  AddRecordFlags(app, flags.record);
  app.add_flag("--localise-only", flags.localise_only,
               "Map nothing: track the camera in what others mapped")
      ->group(kRareGroup);
  app.add_flag("--strict", flags.strict,
               "Refuse a source in which something looks wrong, instead of warning");
  app.add_flag("--take-over", flags.take_over,
               "Take the place of another process of this name that is connected");
  app.add_flag("--stay", flags.stay,
               "At the end say \"finished\" and stay connected until SIGTERM");
  AddTlsFlags(app, flags.security);
  AddServerFlags(app, flags.security);
  AddClientFlags(app, flags.security);
  AddMetricsFlag(app, flags.observe);
  app.add_flag("--listen-insecure", flags.listen_insecure,
               "Without TLS on --listen only, for a loopback address");
}

}  // namespace corbslam::services
