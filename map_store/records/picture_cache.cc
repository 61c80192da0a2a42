#include "map_store/records/picture_cache.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace corbslam::map_store {

void PictureCache::Put(absl::string_view mission, const KeyframePicture& picture,
                       uint64_t max_bytes) {
  const uint64_t bytes = picture.jpeg.size();
  absl::MutexLock lock(&mutex_);
  if (bytes > max_bytes || bytes_ + bytes > kMaxBytes) return;
  OfMission& of_mission = missions_[std::string(mission)];
  if (of_mission.book.Has(picture.keyframe)) return;
  for (const BookedPicture& oldest : of_mission.book.TakeBeyond(max_bytes - bytes)) {
    of_mission.pictures.erase(oldest.keyframe);
    bytes_ -= oldest.bytes;
  }
  of_mission.book.Add(picture.keyframe, bytes, 0);
  of_mission.pictures[picture.keyframe] = picture;
  bytes_ += bytes;
}

absl::StatusOr<KeyframePicture> PictureCache::Read(absl::string_view mission,
                                                   KeyframeId keyframe) const {
  absl::MutexLock lock(&mutex_);
  if (const auto found = missions_.find(std::string(mission)); found != missions_.end()) {
    const auto picture = found->second.pictures.find(keyframe);
    if (picture != found->second.pictures.end()) return picture->second;
  }
  return absl::NotFoundError(absl::StrCat("keyframe ", ToString(keyframe), " has no picture"));
}

void PictureCache::Remove(absl::string_view mission, const std::vector<KeyframeId>& keyframes) {
  absl::MutexLock lock(&mutex_);
  const auto found = missions_.find(std::string(mission));
  if (found == missions_.end()) return;
  for (const KeyframeId& keyframe : keyframes) {
    if (const auto taken = found->second.book.Take(keyframe)) bytes_ -= taken->bytes;
    found->second.pictures.erase(keyframe);
  }
}

void PictureCache::RemoveMission(absl::string_view mission) {
  absl::MutexLock lock(&mutex_);
  const auto found = missions_.find(std::string(mission));
  if (found == missions_.end()) return;
  bytes_ -= found->second.book.bytes();
  missions_.erase(found);
}

}  // namespace corbslam::map_store
