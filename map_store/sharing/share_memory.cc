#include "map_store/sharing/share_memory.h"

#include <algorithm>
#include <cstddef>

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kSampled = 8;

uint64_t BytesOf(const std::shared_ptr<const Sights>& sights) {
  // The list, its entries, and the count of its users.
  constexpr uint64_t kOfList = 2 * HeapBlockBytes(sizeof(Sights));
  if (sights == nullptr) return 0;
  return (kOfList + VectorBytes(*sights)) / static_cast<uint64_t>(sights.use_count());
}

uint64_t BytesOfSights(const std::map<KeyframeId, SentKeyframe>& keyframes) {
  uint64_t sampled = 0;
  uint64_t bytes = 0;
  for (const auto& [id, sent] : keyframes) {
    if (sampled == kSampled) break;
    ++sampled;
    bytes += BytesOf(sent.sights);
  }
  return sampled == 0 ? 0 : keyframes.size() * bytes / sampled;
}

uint64_t BytesOf(const ShareNews& news) {
  return BtreeBytes<KeyframeId>(news.keyframes.size() + news.sights.size()) +
         BtreeBytes<MapPointId>(news.points.size() + news.landmarks.size()) +
         BtreeBytes<decltype(news.own_landmarks)::value_type>(news.own_landmarks.size());
}

}  // namespace

uint64_t EstimateMemory(const ShareState& share) {
  using Landmark = decltype(share.landmarks)::value_type;
  using OwnKeyframe = decltype(share.own_keyframes)::value_type;
  return TreeBytes<decltype(share.keyframes)::value_type>(share.keyframes.size()) +
         BytesOfSights(share.keyframes) +
         BtreeBytes<decltype(share.points)::value_type>(share.points.size()) +
         BtreeBytes<Landmark>(share.landmarks.size()) +
         share.landmarks.size() * HeapBlockBytes(sizeof(MapPointId)) +
         TreeBytes<OwnKeyframe>(share.own_keyframes.size()) + BytesOf(share.news) +
         2 * BtreeBytes<std::pair<double, KeyframeId>>(share.far.size());
}

}  // namespace corbslam::map_store
