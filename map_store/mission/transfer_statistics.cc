#include "map_store/mission/transfer_statistics.h"

namespace corbslam::map_store {

BatchTransfer EstimateTransfer(const MapUpdateBatch& batch) {
  constexpr uint64_t kBytesPerKeypoint = 48;
  BatchTransfer transfer;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    transfer.full_keyframe_bytes +=
        100 + kBytesPerKeypoint * keyframe.payload->features.keypoints.size();
  }
  transfer.full_map_point_bytes = 90 * batch.full_points.size();
  transfer.light_keyframe_bytes = 70 * batch.light_keyframes.size();
  transfer.light_map_point_bytes = 30 * batch.light_points.size();
  return transfer;
}

void CountTransfer(const MapUpdateBatch& batch, const BatchTransfer& transfer, double ms,
                   MissionStatistics& statistics) {
  const double bytes =
      static_cast<double>(transfer.full_keyframe_bytes + transfer.full_map_point_bytes +
                          transfer.light_keyframe_bytes + transfer.light_map_point_bytes);
  const double ms_per_byte = bytes > 0 ? ms / bytes : 0;
  const auto count = [ms_per_byte](TransferStatistics& counted, size_t items, uint64_t size) {
    counted.count += items;
    counted.bytes += size;
    counted.ms += ms_per_byte * static_cast<double>(size);
  };
  count(statistics.full_keyframes, batch.full_keyframes.size(), transfer.full_keyframe_bytes);
  count(statistics.full_map_points, batch.full_points.size(), transfer.full_map_point_bytes);
  count(statistics.light_keyframes, batch.light_keyframes.size(), transfer.light_keyframe_bytes);
  count(statistics.light_map_points, batch.light_points.size(), transfer.light_map_point_bytes);
}

}  // namespace corbslam::map_store
