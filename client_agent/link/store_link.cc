#include "client_agent/link/store_link.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "slam/util/named_thread.h"

namespace corbslam::client_agent {
namespace {

UploadQueueOptions MakeQueueOptions(const StoreLinkOptions& options, LocalMapId goes_on) {
  UploadQueueOptions queue;
  queue.max_memory_bytes = options.max_outbox_bytes;
  queue.write_all = options.spool_within > absl::ZeroDuration();
  queue.keep = queue.write_all && options.resumable;
  queue.goes_on = goes_on;
  return queue;
}

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
      backoff_(options.min_backoff, options.max_backoff, options.seed),
      refused_backoff_(options.min_refused_backoff, options.max_refused_backoff, options.seed) {}

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
  if (!queue_.SpillAll()) WriteHeldBack(/*now=*/true);
}

void StoreLink::BeginLocalMap(GuardedMap& map, MapJobs& jobs, const SpooledMap* spooled_map,
                              Earlier earlier) {
  if (uplink_ == nullptr) return;
  RecorderOptions recorder_options;
  recorder_options.recorded_camera = options_.recorded_camera;
  recorder_options.features = options_.features;
  recorder_options.hold_newest = options_.hold_newest_keyframes;
  auto recording = std::make_unique<Recording>();
  recording->map = &map;
  recording->recorder = std::make_unique<UpdateRecorder>(map.local_map(), recorder_options);
  UpdateRecorder* const recorder = recording->recorder.get();
  if (spooled_map != nullptr) recorder->GoOnFrom(*spooled_map);
  auto inbox = std::make_shared<SharedInbox>(map.local_map(), jobs, *uplink_, options_.inbox);
  {
    absl::MutexLock lock(&mutex_);
    DeliverFrames();
    for (auto& recorded : recordings_) recorded->closing |= earlier == Earlier::kHaveEnded;
    // What was shared was placed in the map that ends, so that the store must tell it again.
    reopen_ |= !recordings_.empty();
    inbox_.swap(inbox);
    for (const MapContradiction& found : left_out_) inbox_->LeaveOut(found.local_map);
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

void StoreLink::EndLocalMap(LocalMapId local_map) {
  absl::MutexLock lock(&mutex_);
  for (auto& recording : recordings_) {
    recording->closing |= recording->map->local_map() == local_map;
  }
  wake_ = true;
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
    queue_.ReleaseHeldBack(map->local_map());
  }
  absl::MutexLock lock(&mutex_);
  std::erase_if(recordings_, [&](const auto& recording) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (std::ranges::find(closed, recording->map) == closed.end()) return false;
    refused_items_ += recording->recorder->refused_items();
    return true;
  });
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

void StoreLink::Start() {
  if (uplink_ == nullptr || thread_.joinable()) return;
  thread_ = StartThread("store link", [this] { Run(); });
}

void StoreLink::Step() {
  if (uplink_ == nullptr) return;
  ConnectIfDue();
  PlaceAnew();
  TakeBatches(/*all=*/true);
  LetGoOfClosed();
  if (WritesAll()) SpillDue(/*now=*/true);
  SendUnsent();
  SendReport();
  SendPictures();
  SpillDue(/*now=*/true);
}

void StoreLink::Run() {
  while (WaitForWork()) {
    ConnectIfDue();
    PlaceAnew();
    TakeBatches(/*all=*/false);
    LetGoOfClosed();
    if (WritesAll()) SpillDue(/*now=*/false);
    SendUnsent();
    SendReport();
    SendPictures();
    // A robot that ends may be killed before all is acknowledged.
    IsFinishing() ? static_cast<void>(queue_.SpillAll()) : SpillDue(/*now=*/false);
  }
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

}  // namespace corbslam::client_agent
