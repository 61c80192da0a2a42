#include "client_agent/link/localised_outbox.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "slam/exchange/item_checks.h"
#include "slam/util/mixed_bits.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kLeastFrames = 1000;

// Draws the number of a run, which is never 0.
uint64_t DrawRun(uint64_t seed) { return std::max<uint64_t>(MixBits(seed + kGoldenGamma), 1); }

// Returns false, and says why, for what a store would end the session for.
bool Admit(const absl::Status& check) {
  if (check.ok()) return true;
  LOG_FIRST_N(ERROR, 20) << "not told to the map store, which would refuse it: " << check.message();
  return false;
}

}  // namespace

LocalisedOutbox::LocalisedOutbox(size_t max_bytes, uint64_t seed,
                                 std::optional<RecordedCamera> recorded_camera)
    : max_frames_(std::max(max_bytes / sizeof(Frame), kLeastFrames)),
      recorded_camera_(std::move(recorded_camera)),
      run_(DrawRun(seed)),
      backoff_(kPatience, kLongestPatience, seed),
      patience_(backoff_.Next()) {}

void LocalisedOutbox::AddPlace(const LocalisedFrame& place) {
  if (!Admit(ValidateTime("frame", place.timestamp_ns))) return;
  absl::MutexLock lock(&mutex_);
  std::optional<Rigid3d>& pose = places_.emplace_back(place).camera_from_global;
  if (pose.has_value() && !Admit(ValidatePose("frame in", {}, "camera_from_global", *pose))) {
    pose.reset();
  }
  if (places_.size() > kMaxPlaces) places_.pop_front();
}

void LocalisedOutbox::AddTracked(const TrackedFrame& frame) {
  if (!Admit(ValidateTime("frame", frame.timestamp_ns))) return;
  const bool has_pose = frame.reference.IsValid() &&
                        Admit(ValidatePose("frame of", frame.reference, "reference_from_camera",
                                           frame.reference_from_camera));
  absl::MutexLock lock(&mutex_);
  Add({frame, /*is_lost=*/!has_pose});
}

void LocalisedOutbox::AddLost(int64_t timestamp_ns) {
  if (!Admit(ValidateTime("lost frame", timestamp_ns))) return;
  absl::MutexLock lock(&mutex_);
  Add({{timestamp_ns, {}, {}}, /*is_lost=*/true});
}

void LocalisedOutbox::Add(const Frame& frame) {
  if (keeps_ == false) return;
  const size_t count = frames_.size();
  // Of a stretch without poses the two ends are enough.
  if (frame.is_lost && count >= 2 && frames_[count - 1].is_lost && frames_[count - 2].is_lost) {
    frames_.back() = frame;
    return;
  }
  frames_.push_back(frame);
  if (count < max_frames_) return;
  dropped_ += frames_.front().is_lost ? 0 : 1;
  frames_.pop_front();
  Frame& gap = frames_.front();
  dropped_ += gap.is_lost ? 0 : 1;
  gap.is_lost = true;
  LOG_IF(WARNING, !std::exchange(says_dropped_, true))
      << "the map store has not kept the trajectory for long: its oldest frames are dropped, and "
         "it has a gap there";
}

void LocalisedOutbox::BeginSession(bool keeps) {
  absl::MutexLock lock(&mutex_);
  keeps_ = keeps;
  sent_ = 0;
  waits_since_.reset();
  if (keeps) return;
  frames_.clear();
  parts_.clear();
}

void LocalisedOutbox::NoteKept(const LocalisedKept& kept) {
  absl::MutexLock lock(&mutex_);
  if (kept.run != run_ || kept.number > last_number_) return;
  if (kept.number < last_number_ - parts_.size()) return BeginRun();
  if (parts_.empty() || parts_.front().number > kept.number) return;
  while (!parts_.empty() && parts_.front().number <= kept.number) {
    parts_.pop_front();
    sent_ -= std::min<size_t>(sent_, 1);
  }
  waits_since_.reset();
  backoff_.Reset();
  patience_ = backoff_.Next();
}

void LocalisedOutbox::ResetPatience() {
  absl::MutexLock lock(&mutex_);
  backoff_.Reset();
  patience_ = backoff_.Next();
}

void LocalisedOutbox::BeginRun() {
  LOG(WARNING) << "the map store has lost a part of the trajectory that it had kept, as after it "
                  "was restored from a backup: the rest begins another run";
  run_ = DrawRun(run_);
  last_number_ = 0;
  sent_ = 0;
  for (LocalisedFrames& part : parts_) {
    part.run = run_;
    part.number = ++last_number_;
  }
  if (!parts_.empty()) parts_.front().recorded_camera = recorded_camera_;
}

void LocalisedOutbox::MakePart(BatchAllowance allowance) {
  LocalisedFrames part;
  part.run = run_;
  part.number = ++last_number_;
  if (part.number == 1) part.recorded_camera = recorded_camera_;
  for (size_t i = 0; i < kMaxFramesOfAPart && !frames_.empty() && !allowance.is_spent(); ++i) {
    allowance.SpendPoses(/*light_keyframes=*/0, /*frames=*/1);
    const Frame& frame = frames_.front();
    if (frame.is_lost) {
      part.lost_frames_ns.push_back(frame.tracked.timestamp_ns);
    } else {
      part.tracked_frames.push_back(frame.tracked);
    }
    frames_.pop_front();
  }
  parts_.push_back(std::move(part));
}

std::vector<LocalisedFrame> LocalisedOutbox::TakePlaces(bool newest_only) {
  std::deque<LocalisedFrame> places;
  places.swap(places_);
  std::vector<LocalisedFrame> taken;
  bool has_pose = false;
  bool has_lost = false;
  for (auto place = places.rbegin(); place != places.rend(); ++place) {
    const bool is_newest =
        !std::exchange(place->camera_from_global.has_value() ? has_pose : has_lost, true);
    if (is_newest || !newest_only) taken.push_back(*place);
  }
  std::ranges::reverse(taken);
  return taken;
}

void LocalisedOutbox::CheckPatience(absl::Time now) {
  if (sent_ == 0 || now - waits_since_.value_or(now) <= patience_) return;
  sent_ = 0;
  waits_since_.reset();
  patience_ = backoff_.Next();
}

std::optional<LocalisedFrames> LocalisedOutbox::Next(LinkBudget& budget, absl::Time now,
                                                     bool is_under_way) {
  absl::MutexLock lock(&mutex_);
  LocalisedFrames message;
  if (keeps_ == true) {
    // What a slow link has not carried can't be answered, and twice it takes twice as long.
    if (is_under_way) waits_since_.reset();
    CheckPatience(now);
    if (sent_ == parts_.size() && !frames_.empty() && parts_.size() < kMaxParts) {
      MakePart(budget.Allow(/*max_keyframes=*/0, now));
    }
    if (sent_ < parts_.size()) message = parts_[sent_++];
    if (sent_ > 0) waits_since_ = waits_since_.value_or(now);
  }
  // Of a trajectory that is kept, and of a link that is narrow, the newest places are enough.
  message.frames = TakePlaces(/*newest_only=*/keeps_ == true || budget.is_bounded());
  if (message.run == 0 && message.frames.empty()) return std::nullopt;
  return message;
}

void LocalisedOutbox::TakeBack(LocalisedFrames unsent) {
  absl::MutexLock lock(&mutex_);
  places_.insert(places_.begin(), unsent.frames.begin(), unsent.frames.end());
  while (places_.size() > kMaxPlaces) places_.pop_front();
  if (unsent.run == run_) sent_ -= std::min<size_t>(sent_, 1);
}

void LocalisedOutbox::SendTo(Uplink& uplink, LinkBudget& budget, absl::Duration interval,
                             absl::Time now) {
  absl::MutexLock sending(&sending_);
  if (now - last_ < interval) return;
  while (true) {
    budget.NoteTransport(uplink, now);
    if (!budget.MayTake(now)) return;
    std::optional<LocalisedFrames> message = Next(budget, now, uplink.bytes_waiting() > 0);
    if (!message.has_value()) return;
    if (!uplink.SendLocalised(*message)) return TakeBack(*std::move(message));
    last_ = now;
  }
}

size_t LocalisedOutbox::CountUnkept() const {
  absl::MutexLock lock(&mutex_);
  size_t count = static_cast<size_t>(
      std::ranges::count_if(frames_, [](const Frame& frame) { return !frame.is_lost; }));
  for (const LocalisedFrames& part : parts_) {
    count += part.tracked_frames.size() + part.lost_frames_ns.size();
  }
  return count;
}

uint64_t LocalisedOutbox::dropped() const {
  absl::MutexLock lock(&mutex_);
  return dropped_;
}

}  // namespace corbslam::client_agent
