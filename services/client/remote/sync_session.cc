#include "services/client/remote/sync_session.h"

#include <utility>

#include "services/convert/agent_report.h"
#include "services/convert/keyframe_picture.h"
#include "services/convert/limits.h"
#include "services/convert/localised_frames.h"
#include "services/convert/map_update.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Bytes that gRPC puts before each message.
constexpr size_t kFrameBytes = 5;

// So much that is unsent goes before the good-bye: a report, and no batch of a slow link.
constexpr size_t kLittle_bytes = 4096;

}  // namespace

SyncSession::SyncSession(std::shared_ptr<SyncTransport> transport,
                         std::unique_ptr<v1::MapStore::Stub> stub, const SessionRequest& request,
                         UplinkListener* listener, size_t max_queued_bytes, EndCallback on_end,
                         DoneCallback on_done)
    : transport_(std::move(transport)),
      stub_(std::move(stub)),
      listener_(listener),
      max_queued_bytes_(max_queued_bytes),
      on_end_(std::move(on_end)),
      on_done_(std::move(on_done)) {
  v1::SyncRequest open;
  ToProto(request, open.mutable_open());
  if (transport_->on_settings != nullptr) {
    open.mutable_open()->add_capabilities(v1::CAPABILITY_ROBOT_SETTINGS);
  }
  absl::MutexLock lock(&mutex_);
  Push(std::move(open));
}

void SyncSession::Start(std::shared_ptr<SyncSession> self) {
  self_ = std::move(self);
  stub_->async()->Sync(&context_, this);
  AddHold();
  StartRead(&response_);
  StartCall();
  WriteNext();
}

bool SyncSession::was_granted() const {
  absl::MutexLock lock(&mutex_);
  return granted_;
}

bool SyncSession::Send(const MapUpdateBatch& batch) {
  {
    absl::MutexLock lock(&mutex_);
    if (!HasRoom()) return false;
    for (v1::MapUpdateBatch& part : ToProto(batch, sent_cameras_, kPartBytes, form_)) {
      v1::SyncRequest request;
      *request.mutable_batch() = std::move(part);
      Push(std::move(request));
    }
  }
  WriteNext();
  return true;
}

bool SyncSession::SendLocalised(const LocalisedFrames& localised) {
  {
    absl::MutexLock lock(&mutex_);
    if (!HasRoom()) return false;
    v1::SyncRequest request;
    ToProto(localised, request.mutable_localised());
    Push(std::move(request));
  }
  WriteNext();
  return true;
}

bool SyncSession::SendPicture(const KeyframePicture& picture) {
  {
    absl::MutexLock lock(&mutex_);
    if (!HasRoom()) return false;
    v1::SyncRequest request;
    ToProto(picture, request.mutable_picture());
    Push(std::move(request));
  }
  WriteNext();
  return true;
}

bool SyncSession::SendReport(const AgentReport& report) {
  {
    absl::MutexLock lock(&mutex_);
    if (!HasRoom()) return false;
    v1::SyncRequest request;
    ToProto(report, request.mutable_report());
    Push(std::move(request));
  }
  WriteNext();
  return true;
}

uint64_t SyncSession::bytes_waiting() const {
  absl::MutexLock lock(&mutex_);
  return UnsentBytes();
}

uint64_t SyncSession::UnsentBytes() const {
  if (broken_ || queue_.empty()) return 0;
  // The message that is being written is on the wire already.
  return writing_ ? queued_bytes_ - (queue_.front().ByteSizeLong() + kFrameBytes) : queued_bytes_;
}

void SyncSession::PauseReading() {
  absl::MutexLock lock(&mutex_);
  // A silenced session reads to its end.
  paused_ = !silenced_;
}

void SyncSession::ResumeReading() {
  {
    absl::MutexLock lock(&mutex_);
    paused_ = false;
    if (!std::exchange(read_waits_, false)) return;
  }
  StartRead(&response_);
  RemoveHold();
}

bool SyncSession::HoldsRead() {
  absl::MutexLock lock(&mutex_);
  if (!paused_) return false;
  AddHold();
  return read_waits_ = true;
}

bool SyncSession::Leave() {
  {
    absl::MutexLock lock(&mutex_);
    silenced_ = true;
  }
  ResumeReading();
  {
    absl::MutexLock lock(&mutex_);
    // What was acknowledged may be on its way still as far as gRPC has told.
    if (!granted_ || broken_ || UnsentBytes() > kLittle_bytes) return false;
    leaves_soon_ = true;
    // OnWriteDone closes the side.
    if (writing_ || !queue_.empty()) return true;
    // This keeps the call alive until OnWritesDoneDone.
    writing_ = leaving_ = true;
  }
  StartWritesDone();
  return true;
}

void SyncSession::OnWritesDoneDone(bool) {
  bool release = false;
  {
    absl::MutexLock lock(&mutex_);
    writing_ = false;
    release = TakeHold();
  }
  if (release) RemoveHold();
}

void SyncSession::Cancel() {
  {
    absl::MutexLock lock(&mutex_);
    silenced_ = true;
  }
  context_.TryCancel();
  // A read that waits learns so that the call has ended.
  ResumeReading();
}

void SyncSession::Push(v1::SyncRequest request) {
  queued_bytes_ += request.ByteSizeLong() + kFrameBytes;
  queue_.push_back(std::move(request));
}

const v1::SyncRequest* SyncSession::NextWrite() {
  if (writing_ || broken_ || leaving_ || queue_.empty()) return nullptr;
  writing_ = true;
  // The bytes are counted before the store can answer.
  transport_->bytes_up += queue_.front().ByteSizeLong() + kFrameBytes;
  return &queue_.front();
}

void SyncSession::WriteNext() {
  const v1::SyncRequest* next = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    next = NextWrite();
  }
  if (next != nullptr) StartWrite(next);
}

bool SyncSession::TakeHold() { return broken_ && !writing_ && std::exchange(held_, false); }

bool SyncSession::IsSilenced() const {
  absl::MutexLock lock(&mutex_);
  return silenced_;
}

void SyncSession::OnWriteDone(bool ok) {
  bool release = false;
  bool leaves = false;
  {
    absl::MutexLock lock(&mutex_);
    queued_bytes_ -= queue_.front().ByteSizeLong() + kFrameBytes;
    queue_.pop_front();
    writing_ = false;
    broken_ |= !ok;
    release = TakeHold();
    leaves = leaves_soon_ && !broken_ && queue_.empty();
    if (leaves) writing_ = leaving_ = true;
  }
  if (release) return RemoveHold();
  if (leaves) return StartWritesDone();
  WriteNext();
}

void SyncSession::OnReadDone(bool ok) {
  if (ok) {
    transport_->bytes_down += response_.ByteSizeLong() + kFrameBytes;
    if (!IsSilenced()) failure_.Update(Handle(response_));
    if (failure_.ok()) {
      if (!HoldsRead()) StartRead(&response_);
      return;
    }
    context_.TryCancel();
  }
  bool release = false;
  {
    absl::MutexLock lock(&mutex_);
    broken_ = true;
    release = TakeHold();
  }
  if (release) RemoveHold();
}

absl::Status SyncSession::Handle(const v1::SyncResponse& response) {
  switch (response.part_case()) {
    case v1::SyncResponse::kGrant: {
      ASSIGN_OR_RETURN(const SessionGrant grant, FromProto(response.grant()));
      {
        absl::MutexLock lock(&mutex_);
        granted_ = true;
        if (grant.capabilities.coded_features) form_ = FeatureForm::kCoded;
      }
      transport_->was_granted = true;
      listener_->OnSessionOpened(grant);
      return absl::OkStatus();
    }
    case v1::SyncResponse::kAcknowledgement: {
      ASSIGN_OR_RETURN(const Acknowledgement entry, FromProto(response.acknowledgement()));
      listener_->OnAcknowledged(entry);
      return absl::OkStatus();
    }
    case v1::SyncResponse::kShared:
      return HandleShared(response.shared());
    case v1::SyncResponse::kExactPlaces:
      listener_->OnExactPlacesWanted();
      return absl::OkStatus();
    case v1::SyncResponse::kSettings:
      if (transport_->on_settings != nullptr) transport_->on_settings(response.settings());
      return absl::OkStatus();
    case v1::SyncResponse::kLocalisedKept:
      listener_->OnLocalisedKept(
          {response.localised_kept().run(), response.localised_kept().number()});
      return absl::OkStatus();
    case v1::SyncResponse::PART_NOT_SET:
      break;
  }
  // The message comes from a newer store and holds nothing that this agent knows.
  return absl::OkStatus();
}

absl::Status SyncSession::HandleShared(const v1::SharedUpdate& part) {
  ASSIGN_OR_RETURN(std::optional<SharedUpdate> update, assembler_.Add(part, received_cameras_));
  if (update) listener_->OnShared(*std::move(update));
  return absl::OkStatus();
}

void SyncSession::OnDone(const grpc::Status& status) {
  if (!IsSilenced()) {
    absl::Status reason = FromGrpcStatus(status);
    if (reason.ok()) reason = absl::UnavailableError("the map store closed the stream");
    // What the store sent was wrong, not what was sent to it: trying again may help.
    if (!failure_.ok()) reason = absl::InternalError(failure_.message());
    if (!on_end_(this, reason)) listener_->OnSessionClosed(reason);
  }
  // At the end `self` destroys this session, unless somebody else holds it.
  const std::shared_ptr<SyncSession> self = std::move(self_);
  const DoneCallback on_done = std::move(on_done_);
  on_done(this);
}

}  // namespace corbslam::services
