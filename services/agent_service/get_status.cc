#include "services/agent_service/agent_service.h"
#include "services/convert/agent_report.h"
#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "services/server/unary.h"

namespace corbslam::services {

using client_agent::AgentStatus;
using client_agent::HeldBack;
using client_agent::kUpdateKinds;
using client_agent::ToString;
using client_agent::TrackingState;
using client_agent::UploadStatus;

namespace {

uint64_t Count(int value) { return static_cast<uint64_t>(value); }

void WriteUpload(const UploadStatus& upload, v1::AgentStatus* response) {
  response->set_outbox_batches(upload.batches);
  response->set_outbox_frames(upload.frames);
  response->set_outbox_memory_bytes(upload.memory_bytes);
  response->set_outbox_spool_bytes(upload.spool_bytes);
  response->set_outbox_code(upload.room.raw_code());
  response->set_lost_local_maps(static_cast<uint32_t>(upload.lost_local_maps));
  response->set_loss_code(upload.loss.raw_code());
}

// Returns what tracking alone says.
AgentActivity ActivityOf(TrackingState state) {
  switch (state) {
    case TrackingState::kNotInitialised:
      break;
    case TrackingState::kTracking:
      return AgentActivity::kTracking;
    case TrackingState::kLost:
      return AgentActivity::kLost;
  }
  return AgentActivity::kInitialising;
}

void WriteActivity(const AgentServiceOptions& options, const AgentStatus& status,
                   v1::AgentStatus* response) {
  response->set_localise_only(options.localise_only);
  AgentReport report{.activity = ActivityOf(status.state)};
  if (options.activity != nullptr) report = options.activity->Report();
  response->set_activity(ToProto(report.activity));
  response->set_newest_frame_age_s(report.newest_frame_age_s);
}

void WriteHeldBack(const HeldBack& held, v1::AgentStatus* response) {
  for (size_t i = 0; i < kUpdateKinds; ++i) {
    v1::HeldBack* kind = response->add_held_back();
    kind->set_kind(static_cast<v1::UpdateKind>(i + 1));
    kind->set_items(held.items[i]);
    kind->set_waited_s(absl::ToDoubleSeconds(held.waited[i]));
  }
}

void WriteSession(const absl::Status& session, v1::AgentStatus* response) {
  response->set_connected(session.ok());
  response->set_session_code(session.raw_code());
  response->set_session_message(std::string(session.message()));
}

void WriteInertial(const AgentStatus& status, v1::AgentStatus* response) {
  if (!status.inertial.has_value()) return;
  const InertialState& state = *status.inertial;
  v1::InertialStatus& written = *response->mutable_inertial();
  written.set_ready(state.is_ready);
  const Eigen::Vector3d& gyro = state.biases.gyro_rps;
  const Eigen::Vector3d& accel = state.biases.accel_mps2;
  written.mutable_gyro_bias_rps()->Add(gyro.begin(), gyro.end());
  written.mutable_accel_bias_mps2()->Add(accel.begin(), accel.end());
  written.set_late_s(state.late_s);
  written.set_late_sigma_s(state.late_sigma_s);
  written.set_noisier(state.noisier);
  written.set_bridged(static_cast<uint32_t>(status.bridged));
}

}  // namespace

grpc::ServerUnaryReactor* AgentService::GetStatus(grpc::CallbackServerContext* context,
                                                  const v1::GetStatusRequest* request,
                                                  v1::AgentStatus* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    const std::string mission =
        options_.mission.empty() ? std::string() : MissionName(options_.mission);
    if (!request->mission().empty() && request->mission() != mission) {
      return absl::FailedPreconditionError(
          absl::StrCat("this agent's mission is \"", mission, "\""));
    }
    const AgentStatus status = agent_.GetStatus();
    response->set_mission(mission);
    response->set_agent(options_.agent);
    response->set_state(ToProto(status.state));
    response->set_why_no_pose(ToProto(status.why_no_pose));
    response->set_mapping_paused(status.mapping_paused);
    response->set_local_map(ToString(status.local_map));
    response->set_frames(Count(status.frames));
    response->set_tracked(Count(status.tracked));
    response->set_dropped(poses_.dropped());
    response->set_lost(Count(status.lost));
    response->set_keyframes(Count(status.keyframes));
    response->set_map_points(Count(status.map_points));
    response->set_shared_keyframes(Count(status.foreign_keyframes));
    response->set_shared_updates(status.shared_updates);
    if (uplink_ != nullptr) response->set_bytes_up(uplink_->bytes_up());
    if (uplink_ != nullptr) response->set_bytes_down(uplink_->bytes_down());
    WriteActivity(options_, status, response);
    WriteUpload(status.upload, response);
    WriteHeldBack(status.upload.held_back, response);
    WriteInertial(status, response);
    if (options_.session != nullptr) WriteSession(options_.session(), response);
    if (status.global_from_local) {
      ToProto(*status.global_from_local, response->mutable_global_from_local());
      response->set_global_without_metres(status.global_without_metres);
    }
    response->set_without_metres(status.without_metres);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
