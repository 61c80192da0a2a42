#include "services/observe/metrics/robot_collector.h"

#include <array>
#include <utility>

#include "services/observe/metrics/families.h"

namespace corbslam::services {

using client_agent::AgentStatus;
using client_agent::HeldBack;
using client_agent::kUpdateKindNames;
using client_agent::kUpdateKinds;
using client_agent::kUplinkHolds;
using client_agent::UpdateKind;
using client_agent::UploadStatus;

namespace {

double Number(uint64_t value) { return static_cast<double>(value); }

void AddMap(const AgentStatus& status, Families& families) {
  families.Counter("corbslam_robot_local_maps_total", "Local maps begun.", status.local_maps);
  families.Counter("corbslam_robot_hand_overs_total",
                   "Local maps begun because the one before was full.", status.hand_overs);
  families.Counter("corbslam_robot_brought_back_keyframes_total",
                   "Keyframes that came back from the spool after they had left memory.",
                   Number(status.far.brought_back));
  families.Gauge("corbslam_robot_map_bytes",
                 "About what the local map in use takes in memory, with what others made in it.",
                 Number(status.map_bytes));
  families.Gauge("corbslam_robot_keyframes", "Own keyframes of all local maps.", status.keyframes);
  families.Gauge("corbslam_robot_map_points", "Own points of all local maps.", status.map_points);
  families.Gauge("corbslam_robot_shared_keyframes", "Keyframes of other robots that are held.",
                 status.foreign_keyframes);
  families.Gauge("corbslam_robot_in_global_frame",
                 "Whether it is known where the local map is in the global frame.",
                 status.global_from_local.has_value());
  families.Counter("corbslam_robot_loops_closed_total", "Loops closed.", status.loops_closed);
}

void AddOutbox(const UploadStatus& upload, Families& families) {
  families.Gauge("corbslam_robot_outbox_batches", "Batches that the store has not acknowledged.",
                 Number(upload.batches));
  families.Gauge("corbslam_robot_outbox_bytes", "Their bytes, in memory and in the spool.",
                 Number(upload.memory_bytes), {{"place", "memory"}});
  families.Gauge("corbslam_robot_outbox_bytes", "", Number(upload.spool_bytes),
                 {{"place", "spool"}});
  families.Gauge("corbslam_robot_outbox_frames",
                 "Frames of the trajectory of a robot that only localises, which the store has not "
                 "said it keeps.",
                 Number(upload.frames));
  families.Gauge("corbslam_robot_outbox_has_room",
                 "0 while changes wait in the map because memory and spool are full or fail.",
                 upload.room.ok());
  families.Counter("corbslam_robot_local_maps_lost_total",
                   "Local maps that could not go on at the store.", upload.lost_local_maps);
  families.Counter("corbslam_robot_items_refused_total",
                   "Items of the map with impossible values, which were not told to the store.",
                   Number(upload.refused_items));
}

// All reasons are there always, so that a rule need not know which were.
void AddHeld(const UploadStatus& upload, Families& families) {
  constexpr std::array<const char*, kUplinkHolds> kReasons = {"none", "opening", "away", "no_room",
                                                              "refused"};
  const auto add = [&](const char* name, const char* what, uint64_t held) {
    for (size_t reason = 1; reason < kUplinkHolds; ++reason) {
      const bool is_why = static_cast<size_t>(upload.hold) == reason;
      families.Gauge(name, what, is_why ? Number(held) : 0, {{"reason", kReasons[reason]}});
    }
  };
  add("corbslam_robot_uplink_held_bytes",
      "Bytes of batches that don't go up, because no session stands, by why.",
      upload.memory_bytes + upload.spool_bytes);
  add("corbslam_robot_uplink_held_keyframes", "Keyframes that wait in the map besides, likewise.",
      upload.held_back.items[static_cast<size_t>(UpdateKind::kKeyframes)]);
}

void AddHeldBack(const HeldBack& held, Families& families) {
  for (size_t kind = 0; kind < kUpdateKinds; ++kind) {
    families.Gauge("corbslam_robot_held_back_items",
                   "What waits in the map to be told to the store.", Number(held.items[kind]),
                   {{"kind", kUpdateKindNames[kind]}});
  }
  for (size_t kind = 0; kind < kUpdateKinds; ++kind) {
    families.Gauge("corbslam_robot_held_back_seconds", "For how long the oldest of it has waited.",
                   absl::ToDoubleSeconds(held.waited[kind]), {{"kind", kUpdateKindNames[kind]}});
  }
}

// All activities are there always, so that a rule need not know which were.
void AddActivity(const AgentReport& report, Families& families) {
  for (const auto& [activity, name] : {std::pair(AgentActivity::kInitialising, "initialising"),
                                       {AgentActivity::kTracking, "tracking"},
                                       {AgentActivity::kLost, "lost"},
                                       {AgentActivity::kWaiting, "waiting"},
                                       {AgentActivity::kFinished, "finished"}}) {
    families.Gauge("corbslam_robot_activity", "1 for what the robot is doing, 0 for the rest.",
                   report.activity == activity, {{"activity", name}});
  }
  families.Gauge("corbslam_robot_newest_frame_age_seconds",
                 "How long ago the newest frame came; 0 before the first.",
                 report.newest_frame_age_s);
}

}  // namespace

std::vector<prometheus::MetricFamily> RobotCollector::Collect() const {
  Families families;
  const AgentStatus status = agent_.GetStatus();
  families.Gauge("corbslam_robot_info", "Which robot this is; always 1.", 1,
                 {{"mission", mission_}, {"agent", name_}});
  if (activity_ != nullptr) AddActivity(activity_->Report(), families);
  AddMap(status, families);
  AddOutbox(status.upload, families);
  AddHeld(status.upload, families);
  AddHeldBack(status.upload.held_back, families);
  families.Counter("corbslam_robot_sent_bytes_total", "Bytes sent to the map store.",
                   uplink_ != nullptr ? Number(uplink_->bytes_up()) : 0);
  families.Counter("corbslam_robot_received_bytes_total", "Bytes received from the map store.",
                   uplink_ != nullptr ? Number(uplink_->bytes_down()) : 0);
  return families.Take();
}

}  // namespace corbslam::services
