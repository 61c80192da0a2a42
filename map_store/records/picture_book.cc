#include "map_store/records/picture_book.h"

#include <algorithm>

namespace corbslam::map_store {

BookedPicture PictureBook::Add(KeyframeId keyframe, uint64_t bytes, uint64_t position) {
  const BookedPicture picture{last_order_ + 1, keyframe, bytes, position};
  Put(picture);
  return picture;
}

void PictureBook::Put(const BookedPicture& picture) {
  // Of two that a damaged index names, one is left.
  Take(picture.keyframe);
  if (const auto it = pictures_.find(picture.order); it != pictures_.end()) {
    Take(it->second.keyframe);
  }
  pictures_[picture.order] = picture;
  orders_[picture.keyframe] = picture.order;
  bytes_ += picture.bytes;
  last_order_ = std::max(last_order_, picture.order);
}

std::optional<BookedPicture> PictureBook::Take(KeyframeId keyframe) {
  const auto order = orders_.find(keyframe);
  if (order == orders_.end()) return std::nullopt;
  const auto it = pictures_.find(order->second);
  const BookedPicture taken = it->second;
  bytes_ -= taken.bytes;
  pictures_.erase(it);
  orders_.erase(order);
  return taken;
}

std::vector<BookedPicture> PictureBook::TakeBeyond(uint64_t max_bytes) {
  std::vector<BookedPicture> taken;
  while (bytes_ > max_bytes) taken.push_back(*Take(pictures_.begin()->second.keyframe));
  return taken;
}

std::vector<BookedPicture> PictureBook::FindUnneeded(
    uint64_t position, const absl::flat_hash_set<KeyframeId>& needed) const {
  std::vector<BookedPicture> unneeded;
  for (const auto& [order, picture] : pictures_) {
    if (picture.position <= position && !needed.contains(picture.keyframe)) {
      unneeded.push_back(picture);
    }
  }
  return unneeded;
}

}  // namespace corbslam::map_store
