// Converts items that travel as columns, to and from the wire. One call writes a column of a
// message; errors are INVALID_ARGUMENT and name the column.
#ifndef CORBSLAM_SERVICES_CONVERT_COLUMNS_H_
#define CORBSLAM_SERVICES_CONVERT_COLUMNS_H_

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "corbslam/v1/items.pb.h"
#include "corbslam/v1/map_update.pb.h"
#include "services/convert/ids.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/shared_update.h"

namespace corbslam::services {

using TimeColumn = google::protobuf::RepeatedField<int64_t>;

template <typename Id>
void WriteIds(std::span<const Id> ids, SlotWriter& slots, v1::ItemIds* proto) {
  IdColumnWriter column(slots, proto);
  for (const Id& id : ids) column.Add(id);
}

// Descriptors of the keyframes of the same message, of which its map points may have copies.
using KeyframeDescriptors = absl::flat_hash_map<KeyframeId, std::span<const Descriptor>>;

// Codes the descriptors of the points that WritePoints has written (docs/wire.md).
void CodeDescriptors(std::span<const FullMapPoint> points, const KeyframeDescriptors& known,
                     v1::FullMapPoints* proto);
void CodeDescriptors(std::span<const SharedMapPoint> points, const KeyframeDescriptors& known,
                     v1::FullMapPoints* proto);

void WritePoints(std::span<const FullMapPoint> points, SlotWriter& slots, v1::FullMapPoints* proto);
void WritePoints(std::span<const SharedMapPoint> points, SlotWriter& slots,
                 v1::FullMapPoints* proto);
void WritePoints(std::span<const LightMapPoint> points, SlotWriter& slots,
                 v1::LightMapPoints* proto);
void WritePoints(std::span<const SharedMapPointMove> points, SlotWriter& slots,
                 v1::LightMapPoints* proto);
void WriteObservations(std::span<const ObservationChange> changes, SlotWriter& slots,
                       v1::ObservationChanges* proto);
void WriteFrames(std::span<const TrackedFrame> frames, SlotWriter& slots, v1::TrackedFrames* proto);
void WriteTimes(std::span<const int64_t> times_ns, TimeColumn* proto);

absl::StatusOr<std::vector<FullMapPoint>> ReadFullPoints(const v1::FullMapPoints& proto,
                                                         const SlotReader& slots,
                                                         const KeyframeDescriptors& known);
absl::StatusOr<std::vector<SharedMapPoint>> ReadSharedPoints(const v1::FullMapPoints& proto,
                                                             const SlotReader& slots,
                                                             const KeyframeDescriptors& known);
absl::StatusOr<std::vector<LightMapPoint>> ReadLightPoints(const v1::LightMapPoints& proto,
                                                           const SlotReader& slots);
absl::StatusOr<std::vector<SharedMapPointMove>> ReadMovedPoints(const v1::LightMapPoints& proto,
                                                                const SlotReader& slots);
absl::StatusOr<std::vector<ObservationChange>> ReadObservations(const v1::ObservationChanges& proto,
                                                                const SlotReader& slots);
absl::StatusOr<std::vector<TrackedFrame>> ReadFrames(const v1::TrackedFrames& proto,
                                                     const SlotReader& slots);
absl::StatusOr<std::vector<int64_t>> ReadTimes(const TimeColumn& proto, absl::string_view field);

// Returns a unit vector if the normal was nearly one, or zero if it is zero.
absl::StatusOr<Eigen::Vector3d> CheckNormal(const Eigen::Vector3d& normal);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_COLUMNS_H_
