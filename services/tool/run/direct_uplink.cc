#include "services/tool/run/direct_uplink.h"

#include <utility>

#include "services/convert/localised_frames.h"
#include "services/convert/map_update.h"
#include "services/convert/shared_update.h"

namespace corbslam::services {

using map_store::MapStore;

namespace {

constexpr size_t kSharedBudget_bytes = 1 << 20;

// Returns the size of the messages that would carry `update`.
template <typename Update>
uint64_t WireBytes(const Update& update, FeatureForm form, CameraBook& sent) {
  uint64_t bytes = 0;
  for (const auto& part : ToProto(update, sent, kSharedBudget_bytes, form)) {
    bytes += part.ByteSizeLong();
  }
  return bytes;
}

// Adds what a part's items take.
void Measure(const v1::MapUpdateBatch& part, map_store::BatchTransfer& transfer) {
  for (const v1::FullKeyframe& keyframe : part.full_keyframes()) {
    transfer.full_keyframe_bytes += keyframe.ByteSizeLong();
  }
  for (const v1::LightKeyframe& keyframe : part.light_keyframes()) {
    transfer.light_keyframe_bytes += keyframe.ByteSizeLong();
  }
  if (part.has_full_points()) transfer.full_map_point_bytes += part.full_points().ByteSizeLong();
  if (part.has_light_points()) transfer.light_map_point_bytes += part.light_points().ByteSizeLong();
}

FeatureForm FormOf(const Capabilities& understood) {
  return understood.coded_features ? FeatureForm::kCoded : FeatureForm::kPlain;
}

}  // namespace

void DirectUplink::Open(const SessionRequest& request, UplinkListener* listener) {
  listener_ = listener;
  absl::StatusOr<MapStore::OpenedSession> opened = store_->OpenSession(request);
  if (!opened.ok()) return End(opened.status());
  session_ = opened->session_id;
  agent_understands_ = request.capabilities;
  store_understands_ = opened->grant.capabilities;
  sent_up_ = {};
  sent_down_ = {};
  listener_->OnSessionOpened(opened->grant);
}

bool DirectUplink::Send(const MapUpdateBatch& batch) {
  if (!session_.has_value()) return false;
  // The store counts what a stream would have brought, as a server of it does.
  map_store::BatchTransfer transfer;
  uint64_t bytes = 0;
  for (const auto& part :
       ToProto(batch, sent_up_, kSharedBudget_bytes, FormOf(store_understands_))) {
    bytes += part.ByteSizeLong();
    Measure(part, transfer);
  }
  const absl::StatusOr<Acknowledgement> stored = store_->Apply(*session_, batch, &transfer);
  if (!stored.ok()) {
    End(stored.status());
    return false;
  }
  bytes_up_ += bytes;
  listener_->OnAcknowledged(*stored);
  return true;
}

bool DirectUplink::SendReport(const AgentReport& report) {
  return session_.has_value() && store_->NoteReport(*session_, report).ok();
}

bool DirectUplink::SendLocalised(const LocalisedFrames& localised) {
  if (!session_.has_value()) return false;
  const auto kept = store_->NoteLocalised(*session_, localised);
  if (!kept.ok()) {
    End(kept.status());
    return false;
  }
  v1::LocalisedFrames message;
  ToProto(localised, &message);
  bytes_up_ += message.ByteSizeLong();
  if (kept->has_value()) listener_->OnLocalisedKept(**kept);
  return true;
}

void DirectUplink::DeliverShared() {
  if (session_.has_value() && store_->TakeExactPlacesWanted(*session_)) {
    listener_->OnExactPlacesWanted();
  }
  while (session_.has_value()) {
    absl::StatusOr<std::optional<SharedUpdate>> update =
        store_->NextShared(*session_, kSharedBudget_bytes);
    if (!update.ok()) return End(update.status());
    if (!update->has_value()) return;
    bytes_down_ += WireBytes(**update, FormOf(agent_understands_), sent_down_);
    listener_->OnShared(std::move(**update));
  }
}

void DirectUplink::Close() {
  if (session_.has_value()) store_->CloseSession(*session_, /*on_purpose=*/true);
  session_.reset();
}

void DirectUplink::End(const absl::Status& reason) {
  if (session_.has_value()) store_->CloseSession(*session_);
  session_.reset();
  listener_->OnSessionClosed(reason);
}

}  // namespace corbslam::services
