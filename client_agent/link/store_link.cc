#include "client_agent/link/store_link.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/exchange/session_end.h"

namespace corbslam::client_agent {
namespace {

bool IsRefusal(const absl::Status& status) {
  return absl::IsAborted(status) || absl::IsInvalidArgument(status) ||
         absl::IsPermissionDenied(status);
}

UploadQueueOptions MakeQueueOptions(const StoreLinkOptions& options, LocalMapId goes_on) {
  UploadQueueOptions queue;
  queue.max_memory_bytes = options.max_outbox_bytes;
  queue.write_all = options.spool_within > absl::ZeroDuration();
  queue.keep = queue.write_all && options.resumable;
  queue.goes_on = goes_on;
  return queue;
}

// What is held back and written again and again takes no more of the disk than this.
constexpr double kHeldBytesPerSecond = 4 << 20;

}  // namespace

StoreLink::StoreLink(const StoreLinkOptions& options, Uplink* uplink, ComputeWords compute_words,
                     std::unique_ptr<Spool> spool, LocalMapId goes_on)
    : options_(options),
      has_link_(uplink != nullptr),
      uplink_(has_link_ || spool == nullptr ? uplink : &no_uplink_),
      compute_words_(std::move(compute_words)),
      queue_(MakeQueueOptions(options, goes_on), std::move(spool)),
      budget_(options.uplink_bytes_per_second),
      // A process that is started again with the same seed has another run.
      localised_(options.max_outbox_bytes,
                 options.seed ^ static_cast<uint64_t>(absl::ToUnixNanos(options.clock())),
                 options.recorded_camera),
      share_(options.share),
      random_(options.seed) {}

StoreLink::~StoreLink() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  if (thread_.joinable()) thread_.join();
  if (uplink_ == nullptr) return;
  uplink_->Close();
  if (!queue_.has_spool()) return;
  // The rest is for the next process; nothing is sent any more.
  budget_.Lift();
  {
    absl::MutexLock lock(&mutex_);
    // Frames are delivered first, because a recorder holds back again with each.
    DeliverFrames();
    for (auto& recording : recordings_) recording->recorder->StopHoldingBack();
  }
  TakeBatches(/*all=*/true);
  if (!queue_.SpillAll()) WriteHeld(/*now=*/true);
}

void StoreLink::BeginLocalMap(GuardedMap& map, MapJobs& jobs, const KeptMap* kept) {
  if (uplink_ == nullptr) return;
  RecorderOptions recorder_options;
  recorder_options.recorded_camera = options_.recorded_camera;
  recorder_options.features = options_.features;
  recorder_options.hold_newest = options_.hold_newest_keyframes;
  auto recording = std::make_unique<Recording>();
  recording->map = &map;
  recording->recorder = std::make_unique<UpdateRecorder>(map.local_map(), recorder_options);
  UpdateRecorder* const recorder = recording->recorder.get();
  if (kept != nullptr) recorder->GoOnFrom(*kept);
  auto inbox = std::make_shared<SharedInbox>(map.local_map(), jobs, *uplink_, options_.inbox);
  {
    absl::MutexLock lock(&mutex_);
    DeliverFrames();
    for (auto& earlier : recordings_) earlier->closing = true;
    // What was shared was placed in the map that ends, so that the store must tell it again.
    reopen_ |= !recordings_.empty();
    inbox_.swap(inbox);
    share_watch_ = ShareWatch();
    anew_ = ShareAnew();
    recorder->SetPointsFollow(store_moves_points_);
    recording->closed = options_.localise_only || !queue_.Begin(map.local_map());
    needs_new_local_map_ = recording->closed && !options_.localise_only;
    recordings_.push_back(std::move(recording));
    wake_ = true;
  }
  if (inbox != nullptr) inbox->Close();
  if (!options_.localise_only) map.SetObserver(recorder);
}

bool StoreLink::Reads(LocalMapId local_map) const {
  absl::MutexLock lock(&mutex_);
  return std::ranges::any_of(recordings_, [local_map](const auto& recording) {
    return recording->map->local_map() == local_map;
  });
}

// Recordings go on this thread alone, because it reads them without the lock.
void StoreLink::LetGoOfClosed() {
  std::vector<GuardedMap*> closed;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& recording : recordings_) {
      if (recording->closed && recording != recordings_.back()) closed.push_back(recording->map);
    }
  }
  if (closed.empty()) return;
  for (GuardedMap* map : closed) {
    map->SetObserver(nullptr);
    queue_.ReleaseHeld(map->local_map());
  }
  absl::MutexLock lock(&mutex_);
  std::erase_if(recordings_, [&](const auto& recording) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (std::ranges::find(closed, recording->map) == closed.end()) return false;
    refused_items_ += recording->recorder->refused_items();
    return true;
  });
}

std::shared_ptr<SharedInbox> StoreLink::CurrentInbox() const {
  absl::MutexLock lock(&mutex_);
  return inbox_;
}

void StoreLink::OnCorrected(LocalMapId local_map, const OwnCorrection& correction,
                            GuardedMap& map) {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  if (inbox != nullptr && inbox->local_map() == local_map) inbox->Correct(correction, map);
}

void StoreLink::AddTrackedFrame(const TrackedFrame& frame) {
  if (uplink_ == nullptr) return;
  options_.localise_only ? localised_.AddTracked(frame) : frames_.Add(frame, options_.clock());
}

void StoreLink::AddLostFrame(int64_t timestamp_ns) {
  if (uplink_ == nullptr) return;
  if (options_.localise_only) return localised_.AddLost(timestamp_ns);
  frames_.Add(FrameInbox::LostFrame{timestamp_ns}, options_.clock());
}

void StoreLink::AddLocalised(const LocalisedFrame& frame) {
  if (uplink_ != nullptr && options_.localise_only) localised_.AddPlace(frame);
}

void StoreLink::DeliverFrames() {
  for (const FrameInbox::Frame& frame : frames_.Take()) {
    if (const auto* lost = std::get_if<FrameInbox::LostFrame>(&frame)) {
      if (!recordings_.empty()) recordings_.back()->recorder->AddLostFrame(lost->timestamp_ns);
      continue;
    }
    const auto& tracked = std::get<TrackedFrame>(frame);
    for (auto& recording : recordings_) {
      if (recording->map->local_map() != tracked.reference.local_map) continue;
      recording->recorder->AddTrackedFrame(tracked);
    }
  }
}

void StoreLink::Start() {
  if (uplink_ == nullptr || thread_.joinable()) return;
  thread_ = std::thread([this] { Run(); });
}

void StoreLink::Step() {
  if (uplink_ == nullptr) return;
  ConnectIfDue();
  PlaceAnew();
  TakeBatches(/*all=*/true);
  LetGoOfClosed();
  if (WritesAll()) SpillDue(/*now=*/true);
  SendUnsent();
  SpillDue(/*now=*/true);
}

absl::Status StoreLink::Finish(absl::Duration timeout) {
  if (uplink_ == nullptr) return absl::OkStatus();
  if (options_.localise_only) SendLocalised(/*all=*/true);
  {
    absl::MutexLock lock(&mutex_);
    for (auto& recording : recordings_) recording->closing = true;
    if (!recordings_.empty()) {
      recordings_.back()->stays_open = options_.resumable && WritesAll();
    }
    wake_ = true;
  }
  if (!thread_.joinable()) Step();
  absl::MutexLock lock(&mutex_);
  const auto finished = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return IsDone() || session_ == Session::kRefused || IsToldWithoutLink();
  };
  if (!mutex_.AwaitWithTimeout(absl::Condition(&finished), timeout)) {
    return absl::DeadlineExceededError(
        absl::StrCat("the map store has not acknowledged everything yet", DescribeWhatIsLeft(),
                     session_ == Session::kOpen || closed_.ok()
                         ? ""
                         : absl::StrCat(", and no session stands: ", closed_.ToString())));
  }
  if (session_ == Session::kRefused) return refusal_;
  if (!has_link_) return queue_.status().room;
  return needs_new_local_map_ ? queue_.status().loss : absl::OkStatus();
}

std::string StoreLink::DescribeWhatIsLeft() const {
  if (options_.localise_only) {
    return absl::StrCat(" (", localised_.CountUnkept(), " frames of the trajectory)");
  }
  if (!budget_.is_bounded()) return "";
  return absl::StrCat(" (", queue_.status().batches, " batches; held back by a budget of ",
                      budget_.bytes_per_second(),
                      " bytes a second: ", ToString(held_back_.status(options_.clock()).items),
                      ")");
}

bool StoreLink::IsToldWithoutLink() const {
  if (has_link_) return false;
  const bool told = std::all_of(recordings_.begin(), recordings_.end(),
                                [](const auto& recording) { return recording->closed; });
  // A disk that is full is not waited for.
  return told && !queue_.status().room.ok();
}

bool StoreLink::IsDone() const {
  if (has_link_ ? !queue_.IsEmpty() : !queue_.IsOnDisk()) return false;
  if (localised_.CountUnkept() > 0) return false;
  return std::all_of(recordings_.begin(), recordings_.end(),
                     [](const auto& recording) { return recording->closed; });
}

void StoreLink::Run() {
  while (WaitForWork()) {
    ConnectIfDue();
    PlaceAnew();
    TakeBatches(/*all=*/false);
    LetGoOfClosed();
    if (WritesAll()) SpillDue(/*now=*/false);
    SendUnsent();
    // A robot that ends may be killed before all is acknowledged.
    IsFinishing() ? static_cast<void>(queue_.SpillAll()) : SpillDue(/*now=*/false);
  }
}

void StoreLink::SpillDue(bool now) {
  if (!has_link_ && IsFinishing()) {
    queue_.SpillAll();
  } else {
    queue_.Spill();
  }
  WriteHeld(now);
}

void StoreLink::WriteHeld(bool now) {
  if (!WritesAll() || (!now && options_.clock() < next_held_)) return;
  std::vector<Recording*> open;
  {
    absl::MutexLock lock(&mutex_);
    DeliverFrames();
    for (auto& recording : recordings_) {
      if (!recording->closed) open.push_back(recording.get());
    }
  }
  const bool anew = queue_.TakeHeldLost();
  for (Recording* recording : open) WriteHeldOf(*recording, anew);
}

// Only this thread takes batches, so that none comes between the copy and its record.
void StoreLink::WriteHeldOf(Recording& recording, bool anew) {
  if (anew) recording.recorder->CopyHeldAnew();
  const uint64_t changes = recording.recorder->held_changes();
  if (recording.held == changes) return;
  const HeldItems held =
      recording.map->Read([&](const Map& map) { return recording.recorder->CopyHeld(map); });
  const std::optional<uint64_t> bytes = queue_.WriteHeld(held);
  if (!bytes.has_value()) {
    recording.recorder->CopyHeldAnew();
    recording.held.reset();
    return;
  }
  recording.held = changes;
  next_held_ =
      options_.clock() + std::max(options_.spool_within / 4,
                                  absl::Seconds(static_cast<double>(*bytes) / kHeldBytesPerSecond));
}

bool StoreLink::IsFinishing() const {
  absl::MutexLock lock(&mutex_);
  return std::all_of(recordings_.begin(), recordings_.end(),
                     [](const auto& recording) { return recording->closing; });
}

// Returns false when it is time to stop.
bool StoreLink::WaitForWork() {
  absl::MutexLock lock(&mutex_);
  const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return wake_ || stop_; };
  absl::Duration wait = options_.flush_interval;
  if (WritesAll()) wait = std::min(wait, options_.spool_within / 4);
  if (session_ == Session::kNone) wait = std::min(wait, next_attempt_ - options_.clock());
  mutex_.AwaitWithTimeout(absl::Condition(&has_work), wait);
  wake_ = false;
  return !stop_;
}

absl::Duration StoreLink::NextBackoff() {
  const double growth = static_cast<double>(uint64_t{1} << std::min(attempts_++, 10));
  const absl::Duration longest = std::min(options_.min_backoff * growth, options_.max_backoff);
  std::uniform_real_distribution<double> jitter(0.5, 1.0);
  return longest * jitter(random_);
}

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
  }
  if (close_first) uplink_->Close();
  uplink_->Open(request, this);
}

// Before its first batch nothing of a local map is safe in the spool.
bool StoreLink::BeginsInSpool(const Recording& recording) const {
  return WritesAll() && !recording.closed && !queue_.HasBegun(recording.recorder->local_map());
}

bool StoreLink::FlushIsDue() const {
  const absl::Duration age = options_.clock() - last_flush_;
  if (!queue_.HasUnsent() && age >= options_.flush_interval) return true;
  if (age >= options_.backlog_flush_interval) return true;
  const bool begins =
      std::any_of(recordings_.begin(), recordings_.end(),
                  [this](const auto& recording)
                      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return BeginsInSpool(*recording); });
  if (begins && age >= options_.flush_interval) return true;
  return std::any_of(recordings_.begin(), recordings_.end(), [this](const auto& recording) {
    return !recording->closed && (recording->closing || recording->recorder->pending_keyframes() >=
                                                            options_.max_keyframes_per_batch);
  });
}

void StoreLink::TakeBatches(bool all) {
  std::vector<Recording*> open;
  std::vector<Recording*> beginning;
  {
    absl::MutexLock lock(&mutex_);
    if (!all && !FlushIsDue()) return;
    last_flush_ = options_.clock();
    DeliverFrames();
    const bool no_frames_come = !all && last_flush_ - frames_.last_added() > options_.max_hold;
    for (auto& recording : recordings_) {
      if (recording->closed) continue;
      if (BeginsInSpool(*recording)) beginning.push_back(recording.get());
      if (no_frames_come || BeginsInSpool(*recording)) recording->recorder->StopHoldingBack();
      open.push_back(recording.get());
    }
    // Under a budget the first local map may leave nothing for the others: they take turns.
    if (IsBudgeted() && open.size() > 1) {
      std::rotate(open.begin(), open.begin() + static_cast<ptrdiff_t>(turn_++ % open.size()),
                  open.end());
    }
  }
  NoteTransport();
  for (Recording* recording : open) {
    while (TakeBatchOf(*recording)) queue_.Spill();
  }
  for (Recording* recording : beginning) recording->recorder->HoldBack();
  absl::MutexLock lock(&mutex_);
  NoteHeldBack();
}

bool StoreLink::IsBudgeted() const {
  return budget_.is_bounded() && (session_ == Session::kOpen || !queue_.has_spool());
}

void StoreLink::NoteTransport() {
  // Bytes that move on between the two calls count twice until the next time, rather than never.
  const uint64_t waiting = uplink_->bytes_waiting();
  budget_.NoteTransport(uplink_->bytes_up(), waiting, options_.clock());
}

void StoreLink::NoteHeldBack() {
  UpdateCounts waiting = {};
  for (const auto& recording : recordings_) {
    if (recording->closed) continue;
    const UpdateCounts untold = recording->recorder->CountUntold();
    for (size_t kind = 0; kind < kUpdateKinds; ++kind) waiting[kind] += untold[kind];
  }
  held_back_.NoteWaiting(waiting, options_.clock());
}

UplinkHold StoreLink::FindHold() const {
  if (!has_link_ || session_ == Session::kOpen) return UplinkHold::kNone;
  // What is tried again is held for the reason of the last time, until that is over.
  const absl::Status& why = session_ == Session::kRefused ? refusal_ : closed_;
  if (absl::IsResourceExhausted(why)) return UplinkHold::kNoRoom;
  if (absl::IsUnavailable(why) || absl::IsDeadlineExceeded(why)) return UplinkHold::kAway;
  return why.ok() ? UplinkHold::kOpening : UplinkHold::kRefused;
}

UploadStatus StoreLink::upload() const {
  UploadStatus status = queue_.status();
  absl::MutexLock lock(&mutex_);
  status.held_back = held_back_.status(options_.clock());
  status.refused_items = refused_items_;
  status.hold = FindHold();
  for (const auto& recording : recordings_) {
    status.refused_items += recording->recorder->refused_items();
  }
  return status;
}

// Moves one batch from the recorder to the outbox; returns false when there is none, no room, or no
// budget.
bool StoreLink::TakeBatchOf(Recording& recording) {
  bool closing = false;
  BatchAllowance allowance(options_.max_keyframes_per_batch);
  {
    absl::MutexLock lock(&mutex_);
    if (recording.closed || !queue_.HasRoom()) return false;
    if (IsBudgeted()) {
      // No batch is made while others are late: changes wait in the map, where they coalesce.
      if (queue_.HasUnsent() || !budget_.MayTake(options_.clock())) return false;
      allowance = budget_.Allow(options_.max_keyframes_per_batch, options_.clock());
    }
    closing = recording.closing;
    if (closing && !std::exchange(recording.asked_for_exact_places, true)) {
      recording.recorder->AskForExactPlaces();
    }
  }
  MapUpdateBatch batch;
  if (recording.recorder->HasChanges()) {
    batch = recording.map->Read(
        [&](const Map& map) { return recording.recorder->TakeBatch(map, allowance); });
  }
  const bool last = IsEmpty(batch);
  if (last && !closing) return false;
  // What is held back is to be written for what was told now.
  next_held_ = absl::InfinitePast();
  absl::MutexLock lock(&mutex_);
  if (recording.closed) return false;
  batch.local_map = recording.map->local_map();
  batch.closes_local_map = last;
  recording.closed = last;
  if (last && recording.stays_open) return false;
  held_back_.NoteTaken(CountUpdates(batch));
  queue_.Push(std::move(batch));
  return !last;
}

void StoreLink::SendLocalised(bool all) {
  {
    absl::MutexLock lock(&mutex_);
    if (session_ != Session::kOpen) return;
  }
  const absl::Duration interval = all ? absl::ZeroDuration() : options_.flush_interval;
  localised_.SendTo(*uplink_, interval, options_.clock());
}

void StoreLink::SendUnsent() {
  if (options_.localise_only) SendLocalised(/*all=*/false);
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      if (session_ != Session::kOpen) return;
    }
    NoteTransport();
    if (!budget_.MaySend(options_.clock())) return;
    const uint64_t before = uplink_->bytes_up() + uplink_->bytes_waiting();
    std::vector<LostLocalMap> lost;
    const std::shared_ptr<const MapUpdateBatch> batch = queue_.TakeUnsent(lost);
    if (!lost.empty()) {
      absl::MutexLock lock(&mutex_);
      GiveUp(lost);
    }
    if (batch == nullptr) return;
    if (!uplink_->Send(*batch)) {
      queue_.MarkUnsent();
      return;
    }
    const uint64_t after = uplink_->bytes_up() + uplink_->bytes_waiting();
    budget_.NoteSent(*batch, after - std::min(after, before));
  }
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

void StoreLink::OnSessionOpened(const SessionGrant& grant) {
  absl::MutexLock lock(&mutex_);
  if (options_.localise_only && !grant.capabilities.localise_only) {
    // It would wait for batches, and tells nothing to an agent without a local map.
    session_ = Session::kRefused;
    refusal_ = absl::FailedPreconditionError(
        "the map store is of an older version, which knows no robots that only localise: bring it "
        "up to date, or run this robot without --localise-only");
    LOG(ERROR) << refusal_;
    return;
  }
  NoteCapabilities(grant.capabilities);
  if (options_.localise_only) BeginLocalised(grant.capabilities);
  GiveUp(queue_.Resume(grant));
  session_ = Session::kOpen;
  closed_ = absl::OkStatus();
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

void StoreLink::BeginLocalised(const Capabilities& store) {
  if (!store.keeps_localised && !std::exchange(told_not_kept_, true)) {
    LOG(WARNING) << "the map store is of an older version, which keeps no trajectory of a robot "
                    "that only localises: it can't be asked for it later";
  }
  localised_.BeginSession(store.keeps_localised);
}

void StoreLink::OnLocalisedKept(const LocalisedKept& kept) {
  localised_.NoteKept(kept);
  absl::MutexLock lock(&mutex_);
  attempts_ = 0;
  wake_ = true;
}

void StoreLink::OnExactPlacesWanted() {
  absl::MutexLock lock(&mutex_);
  if (!recordings_.empty()) recordings_.back()->recorder->AskForExactPlaces();
  wake_ = true;
}

void StoreLink::OnAcknowledged(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  queue_.Acknowledge(acknowledgement);
  attempts_ = 0;
  if (!first_acknowledged_.has_value()) first_acknowledged_ = options_.clock();
  wake_ = true;
}

// Computes the words on the thread that hears the update, because they take time that the mapping
// thread does not have: keyframes would wait for it.
ArrivedUpdate StoreLink::Prepare(SharedUpdate update) const {
  ArrivedUpdate arrived;
  for (const SharedKeyframe& keyframe : update.keyframes) {
    arrived.words.push_back(compute_words_(keyframe.payload->features.descriptors));
  }
  arrived.update = std::move(update);
  return arrived;
}

void StoreLink::OnShared(SharedUpdate update) {
  ArrivedUpdate arrived = Prepare(std::move(update));
  std::shared_ptr<SharedInbox> inbox;
  std::optional<LinkEvent> event;
  std::vector<ArrivedUpdate> ready;
  {
    absl::MutexLock lock(&mutex_);
    // The rest of the updates for a map that has ended will be told again for the one that goes on.
    if (session_ != Session::kOpen || reopen_) return;
    // Before its first batch the store does not know the local map: it still tells of the one
    // before, in that one's frame. All will be told again once it knows.
    if (!options_.localise_only && !queue_.HasBegun(inbox_->local_map())) return;
    last_revision_ = arrived.update.revision;
    ++shared_updates_;
    inbox = inbox_;
    event = share_watch_.Add(arrived.update);
    if (anew_.is_waiting()) {
      ready = anew_.Add(std::move(arrived), options_.clock());
    } else {
      ready.push_back(std::move(arrived));
    }
  }
  inbox->AddAll(std::move(ready));
  if (event.has_value()) Tell(*event, inbox->local_map());
}

void StoreLink::AskAnew(double radius_m) {
  const size_t held = shared_keyframes();
  absl::MutexLock lock(&mutex_);
  if (session_ != Session::kOpen || reopen_ || anew_.is_waiting()) return;
  share_.radius_m = radius_m;
  anew_.Begin(held);
  reopen_ = true;
  wake_ = true;
}

void StoreLink::PlaceAnew() {
  std::vector<ArrivedUpdate> ready;
  std::shared_ptr<SharedInbox> inbox;
  {
    absl::MutexLock lock(&mutex_);
    ready = anew_.TakeDue(options_.clock());
    inbox = inbox_;
  }
  if (inbox != nullptr) inbox->AddAll(std::move(ready));
}

void StoreLink::Share(LocalMapId for_local_map, SharedUpdate update) {
  ArrivedUpdate arrived = Prepare(std::move(update));
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  if (inbox != nullptr && inbox->local_map() == for_local_map) inbox->Add(std::move(arrived));
}

void StoreLink::Tell(LinkEvent event, LocalMapId local_map) const {
  if (options_.on_event) options_.on_event(event, local_map);
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
  session_ = passes ? Session::kNone : Session::kRefused;
  if (!passes) refusal_ = reason;
  closed_ = reason;
  // A store that grants sessions and soon ends them again is no reason to come back at once.
  if (options_.clock() - opened_ > options_.max_backoff) attempts_ = 0;
  opened_ = absl::InfiniteFuture();
  next_attempt_ = options_.clock() + NextBackoff();
  wake_ = true;
}

std::optional<Similarity3d> StoreLink::GlobalFromLocal() const {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  return inbox == nullptr ? std::nullopt : inbox->GlobalFromLocal();
}

uint64_t StoreLink::shared_updates() const {
  absl::MutexLock lock(&mutex_);
  return shared_updates_;
}

size_t StoreLink::shared_keyframes() const {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  return inbox == nullptr ? 0 : inbox->keyframes();
}

std::optional<absl::Time> StoreLink::first_acknowledged() const {
  absl::MutexLock lock(&mutex_);
  return first_acknowledged_;
}

}  // namespace corbslam::client_agent
