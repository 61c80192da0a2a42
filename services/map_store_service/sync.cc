#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "map_store/ingest/quota.h"
#include "map_store/view/asleep_error.h"
#include "services/convert/agent_report.h"
#include "services/convert/keyframe_picture.h"
#include "services/convert/limits.h"
#include "services/convert/localised_frames.h"
#include "services/convert/resource_names.h"
#include "services/convert/shared_update.h"
#include "services/convert/status.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/settings_to_proto.h"
#include "services/map_store_service/sync_reactor.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::BatchTransfer;
using map_store::MapStore;

namespace {

// The next message of an agent is not read while so many replies wait to be sent to it.
constexpr size_t kMaxReplies = 64;

// A stream is not read for longer at a time: a limit that was raised meanwhile counts soon.
constexpr absl::Duration kLongestHold = absl::Seconds(10);

constexpr char kBroken[] = "the stream broke: the robot's process or its link is gone";

}  // namespace

SyncReactor::SyncReactor(MapStore& store, TaskPool& pool, StreamLimits& limits,
                         const MapStoreServiceOptions& options, Caller caller)
    : StreamTask(pool, Threads::kTasks),
      store_(store),
      shared_bytes_(options.shared_bytes),
      observers_(options.observers),
      caller_(std::move(caller)),
      peer_(absl::StrReplaceAll(caller_.peer, {{"%5B", "["}, {"%5D", "]"}})),
      limits_(limits.options()) {
  absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket =
      limits.Enter(caller_.peer, caller_.may_stay);
  if (!ticket.ok()) {
    Refuse(ticket.status());
    return;
  }
  ticket_ = *std::move(ticket);
  const absl::Status open =
      ticket_->SetCloseListener(link_.Guard([this](const absl::Status& why) { End(why); }));
  if (!open.ok()) {
    Refuse(open);
    return;
  }
  timer_.Arm(limits_.open_timeout_s, "the first message");
  StartRead(&request_);
}

void SyncReactor::Refuse(const absl::Status& status) {
  NeverWork();
  ticket_.reset();
  Finish(ToGrpcStatus(status));
}

void SyncReactor::OnOverdue(const absl::Status& overdue) {
  Note([this, &overdue]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    // Otherwise the message came in time, and waits for a thread.
    if (!has_request_ && !read_to_end_ && !wants_read_ && !end_) end_ = overdue;
  });
}

void SyncReactor::OnReadDone(bool ok) {
  Note([this, ok]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    (ok ? has_request_ : read_to_end_) = true;
    read_at_ = absl::Now();
  });
}

void SyncReactor::OnWriteDone(bool ok) {
  Note([this, ok]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    writing_ = false;
    replies_.pop_front();
    cancelled_ |= !ok;
  });
}

void SyncReactor::OnCancel() {
  Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { cancelled_ = true; });
}

void SyncReactor::OnShareable() {
  Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { shareable_ = true; });
}

void SyncReactor::OnDone() {
  link_.Cut();
  delete this;
}

SyncJob SyncReactor::NextJob() const {
  if (cancelled_) return writing_ ? SyncJob::kNone : SyncJob::kFinish;
  if (!writing_ && !replies_.empty()) return SyncJob::kWrite;
  if (end_) return writing_ ? SyncJob::kNone : SyncJob::kFinish;
  if (waits_for_mission_) return SyncJob::kNone;
  if (has_request_ && replies_.size() < kMaxReplies) return SyncJob::kRequest;
  if (wants_read_ && !is_held_) return SyncJob::kRead;
  if (read_to_end_ && !has_request_) return writing_ ? SyncJob::kNone : SyncJob::kFinish;
  if (shareable_ && !paced_ && replies_.empty()) return SyncJob::kShare;
  return SyncJob::kNone;
}

void SyncReactor::BeginJob(SyncJob job) { writing_ |= job == SyncJob::kWrite; }

void SyncReactor::DoJob(SyncJob job) {
  switch (job) {
    case SyncJob::kNone:
      return;
    case SyncJob::kWrite:
      return WriteReply();
    case SyncJob::kRequest:
      return HandleRequest();
    case SyncJob::kRead:
      return Read();
    case SyncJob::kShare:
      return Share();
    case SyncJob::kFinish:
      // The reactor may be gone once this is called.
      return Finish(ToGrpcStatus(Leave()));
  }
}

void SyncReactor::WriteReply() {
  const grpc::ByteBuffer* reply = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    reply = &replies_.front();
  }
  StartWrite(reply);
}

absl::Status SyncReactor::Leave() {
  if (session_id_) store_.SetSharedListener(*session_id_, nullptr);
  absl::Status status;
  {
    absl::MutexLock lock(&mutex_);
    // The end of reading may be heard before a cancellation is.
    const bool is_broken = cancelled_ || caller_.is_cancelled();
    status = end_.value_or(is_broken ? absl::CancelledError(kBroken) : absl::OkStatus());
  }
  if (session_id_) store_.CloseSession(*session_id_, /*on_purpose=*/status.ok());
  // The ticket is given back before the agent hears of the end: it may come again at once.
  ticket_.reset();
  if (session_id_) {
    for (SyncObserver* observer : observers_) observer->OnClosed(who_, status);
  }
  return status;
}

void SyncReactor::HandleRequest() {
  absl::Status status;
  if (!asked_.has_value()) {
    asked_bytes_ = request_.Length();
    status = ReadRequest(asked_.emplace());
  }
  if (status.ok()) status = Handle(*asked_);
  if (map_store::AsleepMission(status).has_value()) {
    status = WaitUntilAwake(status);
    if (status.ok()) return;
  }
  const bool is_paced = asked_->has_batch() || asked_->has_localised() || asked_->has_picture();
  asked_.reset();
  if (session_id_) {
    for (SyncObserver* observer : observers_) observer->OnReceived(who_, asked_bytes_);
  }
  if (!status.ok()) return End(status);
  if (session_id_ && is_paced) store_.PaceUplink(*session_id_, asked_bytes_);
  std::shared_ptr<const void> held;
  absl::MutexLock lock(&mutex_);
  has_request_ = false;
  wants_read_ = true;
  held.swap(mission_);
}

void SyncReactor::Read() {
  const absl::Duration wait =
      session_id_ ? store_.PaceUplink(*session_id_, 0) : absl::ZeroDuration();
  if (wait > absl::ZeroDuration()) {
    // The robot is not to blame for a part that is not read.
    timer_.Disarm();
    {
      // The flag is set before the timer can ring.
      absl::MutexLock lock(&mutex_);
      is_held_ = true;
    }
    uplink_timer_.Arm(std::min(wait, kLongestHold), [this] { OnUplinkPaid(); });
    return;
  }
  if (!awaited_.empty()) timer_.Arm(limits_.part_timeout_s, awaited_);
  {
    absl::MutexLock lock(&mutex_);
    wants_read_ = false;
  }
  StartRead(&request_);
}

void SyncReactor::OnUplinkPaid() {
  Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { is_held_ = false; });
}

absl::Status SyncReactor::WaitUntilAwake(const absl::Status& error) {
  {
    // It may be awake before Defer returns.
    absl::MutexLock lock(&mutex_);
    waits_for_mission_ = true;
  }
  return pool().Defer(error, link_.Guard([this](const auto& awake) {
    if (!awake.ok()) {
      for (SyncObserver* observer : observers_) observer->OnRefused(who_, awake.status());
    }
    Note([this, &awake]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      waits_for_mission_ = false;
      if (awake.ok()) mission_ = *awake;
      if (!awake.ok() && !end_) end_ = awake.status();
    });
  }));
}

absl::Status SyncReactor::ReadRequest(v1::SyncRequest& request) {
  if (request_.Length() > limits_.max_message_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "a message has ", request_.Length(), " bytes; the limit is ", limits_.max_message_bytes));
  }
  if (grpc::SerializationTraits<v1::SyncRequest>::Deserialize(&request_, &request).ok()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError("a message can't be read as a SyncRequest");
}

absl::Status SyncReactor::Handle(const v1::SyncRequest& request) {
  if (request.has_open()) return Open(request);
  if (!session_id_) {
    return absl::InvalidArgumentError("the first message must have the part open");
  }
  if (request.has_batch()) return Apply(request.batch());
  if (request.has_localised()) return NoteLocalised(request.localised());
  if (request.has_picture()) {
    return store_.KeepPicture(*session_id_, FromProto(request.picture()));
  }
  if (request.has_report()) return NoteReport(request.report());
  return absl::InvalidArgumentError("a message has no part that is known");
}

absl::Status SyncReactor::Open(const v1::SyncRequest& message) {
  const v1::OpenSession& open = message.open();
  if (session_id_) return absl::InvalidArgumentError("the session is open already");
  ASSIGN_OR_RETURN(SessionRequest request, FromProto(open));
  RETURN_IF_ERROR(caller_.may_open(message));
  RETURN_IF_ERROR(ticket_->Name(AgentName(request.mission, request.agent)));
  request.peer = peer_;
  if (request.capabilities.coded_features) form_ = FeatureForm::kCoded;
  who_ = {request.mission, request.agent,
          caller_.name.empty() ? peer_ : absl::StrCat(caller_.name, " at ", peer_)};
  const absl::StatusOr<MapStore::OpenedSession> session = store_.OpenSession(request);
  if (map_store::AsleepMission(session.status()).has_value()) return session.status();
  if (!session.ok()) {
    for (SyncObserver* observer : observers_) observer->OnRefused(who_, session.status());
    return session.status();
  }
  const MapStore::OpenedSession& opened = *session;
  session_id_ = opened.session_id;
  if (std::ranges::count(open.capabilities(), v1::CAPABILITY_ROBOT_SETTINGS) > 0) {
    told_settings_.emplace();
  }
  pacer_ = SharePacer(request.downlink_bytes_per_second);
  moves_what_is_shared_ = request.share.mode == ShareMode::kNearby;
  for (SyncObserver* observer : observers_) observer->OnOpened(who_);
  timer_.Disarm();
  v1::SyncResponse response;
  ToProto(opened.grant, response.mutable_grant());
  Reply(response);
  store_.SetSharedListener(opened.session_id, link_.Guard([this] { OnShareable(); }));
  // Items may have become shareable before anybody listened.
  absl::MutexLock lock(&mutex_);
  shareable_ = true;
  return absl::OkStatus();
}

absl::Status SyncReactor::Apply(const v1::MapUpdateBatch& part) {
  for (const v1::FullKeyframe& keyframe : part.full_keyframes()) {
    transfer_.full_keyframe_bytes += keyframe.ByteSizeLong();
  }
  for (const v1::LightKeyframe& keyframe : part.light_keyframes()) {
    transfer_.light_keyframe_bytes += keyframe.ByteSizeLong();
  }
  if (part.has_full_points()) transfer_.full_map_point_bytes += part.full_points().ByteSizeLong();
  if (part.has_light_points()) {
    transfer_.light_map_point_bytes += part.light_points().ByteSizeLong();
  }
  // The limit is of the bytes that the part takes in memory, however short it came.
  RETURN_IF_ERROR(ticket_->Hold(UncodedBytes(part)));
  ASSIGN_OR_RETURN(const std::optional<MapUpdateBatch> batch,
                   assembler_.Add(part, received_cameras_));
  if (!batch) {
    awaited_ = absl::StrCat("the next part of batch ", part.number());
    return absl::OkStatus();
  }
  awaited_.clear();
  timer_.Disarm();
  ASSIGN_OR_RETURN(const Acknowledgement stored, ApplyComplete(*batch));
  ticket_->ReleaseAll();
  v1::SyncResponse response;
  ToProto(stored, response.mutable_acknowledgement());
  Reply(response);
  return absl::OkStatus();
}

absl::StatusOr<Acknowledgement> SyncReactor::ApplyComplete(const MapUpdateBatch& batch) {
  for (SyncObserver* observer : observers_) observer->OnBatch(who_, batch);
  const BatchTransfer transfer = std::exchange(transfer_, {});
  const auto stored = store_.Apply(*session_id_, batch, &transfer);
  absl::Duration took;
  {
    absl::MutexLock lock(&mutex_);
    took = absl::Now() - read_at_;
  }
  for (SyncObserver* observer : observers_) {
    observer->OnApplied(who_, batch, took, stored.status());
  }
  // The store tells only the other sessions of this batch.
  if (stored.ok() && moves_what_is_shared_) OnShareable();
  return stored;
}

absl::Status SyncReactor::NoteLocalised(const v1::LocalisedFrames& localised) {
  ASSIGN_OR_RETURN(const LocalisedFrames said, FromProto(localised));
  const size_t bytes = map_store::StoredBytes(said) + said.frames.size() * sizeof(LocalisedFrame);
  RETURN_IF_ERROR(ticket_->Hold(bytes));
  const auto kept = store_.NoteLocalised(*session_id_, said);
  ticket_->Release(bytes);
  RETURN_IF_ERROR(kept.status());
  if (kept->has_value()) {
    v1::SyncResponse response;
    response.mutable_localised_kept()->set_run((*kept)->run);
    response.mutable_localised_kept()->set_number((*kept)->number);
    Reply(response);
  }
  if (moves_what_is_shared_) OnShareable();
  return absl::OkStatus();
}

absl::Status SyncReactor::NoteReport(const v1::AgentReport& report) {
  ASSIGN_OR_RETURN(const AgentReport said, FromProto(report));
  return store_.NoteReport(*session_id_, said);
}

bool SyncReactor::MayShare() {
  const absl::Duration wait = pacer_.Wait(absl::Now());
  if (wait <= absl::ZeroDuration()) return true;
  {
    // The flag is set before the timer can ring.
    absl::MutexLock lock(&mutex_);
    paced_ = true;
  }
  budget_timer_.Arm(wait, [this] { OnBudget(); });
  return false;
}

void SyncReactor::OnBudget() {
  Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { paced_ = false; });
}

void SyncReactor::SendSettings() {
  if (!told_settings_.has_value()) return;
  const std::vector<map_store::SignedSettings> settings =
      store_.NewerSettings(*session_id_, *told_settings_);
  if (settings.empty()) return;
  v1::SyncResponse response;
  *response.mutable_settings() = ToProto(settings);
  Reply(response);
}

void SyncReactor::Share() {
  if (!MayShare()) return;
  {
    // The flag is cleared before the store is asked: what comes meanwhile is asked for again.
    absl::MutexLock lock(&mutex_);
    shareable_ = false;
  }
  if (store_.TakeExactPlacesWanted(*session_id_)) {
    v1::SyncResponse response;
    response.mutable_exact_places();
    Reply(response);
  }
  SendSettings();
  const absl::StatusOr<std::optional<SharedUpdate>> update =
      store_.NextShared(*session_id_, pacer_.Allow(shared_bytes_, absl::Now()));
  if (!update.ok()) return End(update.status());
  if (!update->has_value()) {
    pacer_.NoteSent(0, absl::Now());
    return;
  }
  SendShared(**update);
  // There may be more to share.
  absl::MutexLock lock(&mutex_);
  shareable_ = true;
}

void SyncReactor::SendShared(const SharedUpdate& update) {
  size_t bytes = 0;
  for (v1::SharedUpdate& part : ToProto(update, sent_cameras_, kPartBytes, form_)) {
    bytes += part.ByteSizeLong();
    v1::SyncResponse response;
    *response.mutable_shared() = std::move(part);
    Reply(response);
  }
  const absl::Duration waited = pacer_.NoteSent(bytes, absl::Now());
  if (waited == absl::ZeroDuration()) return;
  for (SyncObserver* observer : observers_) observer->OnShareDelayed(who_, bytes, waited);
}

void SyncReactor::Reply(const v1::SyncResponse& response) {
  grpc::ByteBuffer bytes;
  bool own_buffer = false;
  const grpc::Status written =
      grpc::SerializationTraits<v1::SyncResponse>::Serialize(response, &bytes, &own_buffer);
  if (!written.ok()) return End(FromGrpcStatus(written));
  for (SyncObserver* observer : observers_) observer->OnSent(who_, bytes.Length());
  absl::MutexLock lock(&mutex_);
  replies_.push_back(std::move(bytes));
}

void SyncReactor::End(const absl::Status& status) {
  Note([this, &status]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!end_) end_ = status;
  });
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* MapStoreService::Sync(
    grpc::CallbackServerContext* context, MayAsk may_open) {
  return new SyncReactor(store_, pool_, limits_, options_,
                         {context->peer(), NameOf(*context), std::move(may_open), MayStay(*context),
                          [context] { return context->IsCancelled(); }});
}

}  // namespace corbslam::services
