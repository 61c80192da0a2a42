// Implements the part of StoreLink that opens sessions, and hears how they go on and end.
#include <glog/logging.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client_agent/link/store_link.h"
#include "slam/exchange/session_end.h"

namespace corbslam::client_agent {
namespace {

// Returns whether trying again soon won't help: somebody has to do something first.
bool IsRefusal(const absl::Status& status) {
  return absl::IsAborted(status) || absl::IsInvalidArgument(status) ||
         absl::IsPermissionDenied(status);
}

}  // namespace

void StoreLink::SetShare(const ShareScope& share) {
  absl::MutexLock lock(&mutex_);
  if (share == share_) return;
  share_ = share;
  reopen_ = wake_ = true;
}

void StoreLink::ConnectIfDue() {
  SessionRequest request;
  bool close_first = false;
  {
    absl::MutexLock lock(&mutex_);
    if (reopen_ && (session_ == Session::kOpen || session_ == Session::kOpening)) {
      close_first = true;
      session_ = Session::kNone;
      next_attempt_ = absl::InfinitePast();
    }
    if (reopen_) last_revision_ = 0;
    reopen_ = false;
    if (session_ != Session::kNone || options_.clock() < next_attempt_) return;
    session_ = Session::kOpening;
    shared_updates_ = 0;
    request = {options_.mission, options_.agent, last_revision_, queue_.local_maps()};
    request.capabilities.coded_features = true;
    request.downlink_bytes_per_second = options_.downlink_bytes_per_second;
    request.share = share_;
    request.localise_only = options_.localise_only;
    request.mission_uid = mission_uid_;
  }
  if (close_first) uplink_->Close();
  uplink_->Open(request, this);
}

void StoreLink::OnSessionOpened(const SessionGrant& grant) {
  absl::MutexLock lock(&mutex_);
  if (options_.localise_only && !grant.capabilities.localise_only) {
    // It would wait for batches, and tells nothing to an agent without a local map.
    const absl::Status old = absl::FailedPreconditionError(
        "the map store is of an older version, which knows no robots that only localise: bring it "
        "up to date, or run this robot without --localise-only");
    LOG_IF(ERROR, refusal_ != old) << old;
    return NoteRefusal(old);
  }
  NoteCapabilities(grant.capabilities);
  if (options_.localise_only) BeginLocalised(grant.capabilities);
  pictures_.BeginSession(grant.capabilities.keyframe_pictures);
  store_takes_reports_ = grant.capabilities.takes_reports;
  reported_.reset();
  GiveUp(queue_.Resume(grant));
  session_ = Session::kOpen;
  closed_ = refusal_ = absl::OkStatus();
  if (mission_uid_.empty()) mission_uid_ = grant.mission_uid;
  opened_ = options_.clock();
  wake_ = true;
}

void StoreLink::NoteCapabilities(const Capabilities& store) {
  for (const auto& recording : recordings_) {
    if (!recording->closed) recording->recorder->SetPointsFollow(store.points_follow);
  }
  if (std::exchange(store_moves_points_, store.points_follow) && !store.points_follow) {
    LOG(WARNING) << "the map store is of an older version, which leaves points where they are when "
                    "their keyframes move: every place is told, which takes more bytes; in local "
                    "maps that ended before, points may stand where they were first told";
  }
}

void StoreLink::OnAcknowledged(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  queue_.Acknowledge(acknowledgement);
  backoff_.Reset();
  refused_backoff_.Reset();
  if (!first_acknowledged_.has_value()) first_acknowledged_ = options_.clock();
  wake_ = true;
}

void StoreLink::OnExactPlacesWanted() {
  absl::MutexLock lock(&mutex_);
  if (!recordings_.empty()) recordings_.back()->recorder->AskForExactPlaces();
  wake_ = true;
}

void StoreLink::OnSessionClosed(const absl::Status& reason) {
  NoteClosed(reason);
  if (!SaysMissionDeleted(reason)) return;
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  Tell(LinkEvent::kMissionDeleted, inbox == nullptr ? LocalMapId() : inbox->local_map());
}

void StoreLink::NoteClosed(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  const bool passes =
      !IsRefusal(reason) ||
      (session_ == Session::kOpen && absl::IsInvalidArgument(reason) && queue_.NoteRefusal(reason));
  closed_ = reason;
  if (!passes) return NoteRefusal(reason);
  session_ = Session::kNone;
  refusal_ = absl::OkStatus();
  // A store that grants sessions and soon ends them again is no reason to come back at once.
  if (options_.clock() - opened_ > options_.max_backoff) backoff_.Reset();
  opened_ = absl::InfiniteFuture();
  next_attempt_ = options_.clock() + backoff_.Next();
  wake_ = true;
}

void StoreLink::NoteRefusal(const absl::Status& reason) {
  session_ = SaysMissionDeleted(reason) ? Session::kOver : Session::kNone;
  refusal_ = reason;
  opened_ = absl::InfiniteFuture();
  next_attempt_ = options_.clock() + refused_backoff_.Next();
  wake_ = true;
}

void StoreLink::SendReport() {
  AgentReport report;
  if (options_.report != nullptr) report = options_.report();
  const absl::Time now = options_.clock();
  {
    absl::MutexLock lock(&mutex_);
    if (session_ != Session::kOpen || !store_takes_reports_) return;
    // Who watches no activity has nothing else to say.
    if (options_.report == nullptr && left_out_.empty()) return;
    const bool is_news = reported_ != report.activity || reported_left_out_ != left_out_.size();
    if (!is_news && now < next_report_) return;
    report.contradictions = left_out_;
    if (report.contradictions.size() > AgentReport::kMaxContradictions) {
      report.contradictions.resize(AgentReport::kMaxContradictions);
    }
    reported_left_out_ = left_out_.size();
  }
  if (!uplink_->SendReport(report)) return;
  absl::MutexLock lock(&mutex_);
  reported_ = report.activity;
  next_report_ = now + kReportEvery;
}

void StoreLink::GiveUp(const std::vector<LostLocalMap>& lost) {
  for (const LostLocalMap& local_map : lost) {
    for (auto& recording : recordings_) {
      if (recording->map->local_map() != local_map.id) continue;
      recording->closed = true;
      needs_new_local_map_ |= recording == recordings_.back();
    }
  }
}

bool StoreLink::NeedsNewLocalMap() const {
  absl::MutexLock lock(&mutex_);
  return needs_new_local_map_;
}

std::optional<absl::Time> StoreLink::first_acknowledged() const {
  absl::MutexLock lock(&mutex_);
  return first_acknowledged_;
}

}  // namespace corbslam::client_agent
