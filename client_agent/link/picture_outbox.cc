#include "client_agent/link/picture_outbox.h"

#include <algorithm>
#include <utility>

namespace corbslam::client_agent {

void PictureOutbox::Add(KeyframePicture picture) {
  absl::MutexLock lock(&mutex_);
  if (!takes_ || picture.jpeg.empty() || picture.jpeg.size() > kMaxPictureBytes) return;
  bytes_ += picture.jpeg.size();
  const auto told = std::find(told_.begin(), told_.end(), picture.keyframe);
  if (told != told_.end()) {
    told_.erase(told);
    ready_.push_back(std::move(picture));
  } else {
    untold_.push_back(std::move(picture));
  }
  while (untold_.size() + ready_.size() > kMaxPictures || bytes_ > kMaxBytes) DropOldest();
}

// Those whose keyframes were told are older than the others.
void PictureOutbox::DropOldest() {
  std::deque<KeyframePicture>& from = ready_.empty() ? untold_ : ready_;
  bytes_ -= from.front().jpeg.size();
  from.pop_front();
  ++dropped_;
}

void PictureOutbox::BeginSession(bool takes) {
  absl::MutexLock lock(&mutex_);
  takes_ = takes;
  if (takes) return;
  untold_.clear();
  ready_.clear();
  bytes_ = 0;
}

bool PictureOutbox::Wants() const {
  absl::MutexLock lock(&mutex_);
  return takes_;
}

void PictureOutbox::NoteSent(const MapUpdateBatch& batch) {
  if (batch.full_keyframes.empty()) return;
  absl::MutexLock lock(&mutex_);
  if (!takes_) return;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    const KeyframeId id = keyframe.payload->id;
    const auto picture =
        std::find_if(untold_.begin(), untold_.end(),
                     [&](const KeyframePicture& waiting) { return waiting.keyframe == id; });
    if (picture != untold_.end()) {
      ready_.push_back(std::move(*picture));
      untold_.erase(picture);
      continue;
    }
    // A batch that is sent again has pictures that are gone.
    if (std::find(told_.begin(), told_.end(), id) != told_.end()) continue;
    told_.push_back(id);
    if (told_.size() > kMaxTold) told_.pop_front();
  }
}

bool PictureOutbox::TakeReady(LinkBudget& budget, absl::Time now, KeyframePicture& picture) {
  absl::MutexLock lock(&mutex_);
  if (ready_.empty() || !budget.CanSpare(ready_.front().jpeg.size(), now)) return false;
  picture = std::move(ready_.front());
  ready_.pop_front();
  bytes_ -= picture.jpeg.size();
  return true;
}

void PictureOutbox::SendTo(Uplink& uplink, LinkBudget& budget, absl::Time now) {
  absl::MutexLock sending(&sending_);
  KeyframePicture picture;
  while (true) {
    budget.NoteTransport(uplink, now);
    if (uplink.bytes_waiting() > kMostAhead_bytes || !TakeReady(budget, now, picture)) return;
    const bool sent = uplink.SendPicture(picture);
    absl::MutexLock lock(&mutex_);
    if (!sent) {
      bytes_ += picture.jpeg.size();
      ready_.push_front(std::move(picture));
      return;
    }
    ++sent_;
    sent_bytes_ += picture.jpeg.size();
  }
}

bool PictureOutbox::HasReady() const {
  absl::MutexLock lock(&mutex_);
  return !ready_.empty();
}

PictureOutbox::Counts PictureOutbox::counts() const {
  absl::MutexLock lock(&mutex_);
  return {untold_.size() + ready_.size(), sent_, sent_bytes_, dropped_};
}

}  // namespace corbslam::client_agent
