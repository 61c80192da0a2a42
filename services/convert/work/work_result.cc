#include <cmath>
#include <limits>
#include <utility>

#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/work/work.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::StatusOr<int> ReadCount(absl::string_view field, uint32_t value) {
  constexpr uint32_t kMax = std::numeric_limits<int>::max();
  if (value > kMax) return OutOfRange(field, value, 0u, kMax);
  return static_cast<int>(value);
}

}  // namespace

v1::VerifyOverlapResponse::Header HeaderOf(const VerifyOverlapResult& result) {
  v1::VerifyOverlapResponse::Header header;
  header.set_base_revision(result.base_revision);
  return header;
}

v1::FuseMapsResponse::Header HeaderOf(const FuseMapsResult& result) {
  v1::FuseMapsResponse::Header header;
  header.set_base_revision(result.base_revision);
  header.set_accepted(result.accepted);
  header.set_worst_edge_chi2(result.worst_edge_chi2);
  ToProto(result.target_from_source, header.mutable_target_from_source());
  return header;
}

v1::AdjustBundleResponse::Header HeaderOf(const AdjustBundleResult& result) {
  v1::AdjustBundleResponse::Header header;
  header.set_base_revision(result.base_revision);
  header.set_keyframes(static_cast<uint32_t>(result.keyframes));
  header.set_points(static_cast<uint32_t>(result.points));
  header.set_iterations(static_cast<uint32_t>(result.iterations));
  header.set_initial_cost(result.initial_cost);
  header.set_final_cost(result.final_cost);
  header.set_seconds(result.seconds);
  SlotWriter slots(header.mutable_local_maps());
  IdColumnWriter redundant(slots, header.mutable_redundant());
  for (const KeyframeId& id : result.redundant) redundant.Add(id);
  return header;
}

bool WriteChunks(const VerifyOverlapResult& result, const ChunkSink& sink) {
  ResultItems items;
  items.overlaps = result.overlaps;
  return WriteResultItems(items, sink);
}

bool WriteChunks(const FuseMapsResult& result, const ChunkSink& sink) {
  return WriteResultItems({.poses = result.poses,
                           .positions = result.positions,
                           .merges = result.merges,
                           .rejected = result.rejected,
                           .overlaps = {}},
                          sink);
}

bool WriteChunks(const AdjustBundleResult& result, const ChunkSink& sink) {
  return WriteResultItems({.poses = result.poses,
                           .positions = result.positions,
                           .merges = {},
                           .rejected = result.rejected,
                           .overlaps = {}},
                          sink);
}

absl::StatusOr<VerifyOverlapResult> MakeResult(const v1::VerifyOverlapResponse::Header& header,
                                               ResultItems items) {
  VerifyOverlapResult result;
  result.base_revision = header.base_revision();
  result.overlaps = std::move(items.overlaps);
  return result;
}

absl::StatusOr<FuseMapsResult> MakeResult(const v1::FuseMapsResponse::Header& header,
                                          ResultItems items) {
  FuseMapsResult result;
  result.base_revision = header.base_revision();
  result.accepted = header.accepted();
  result.worst_edge_chi2 = header.worst_edge_chi2();
  ASSIGN_OR_RETURN(result.target_from_source, FromProto(header.target_from_source()));
  result.poses = std::move(items.poses);
  result.positions = std::move(items.positions);
  result.merges = std::move(items.merges);
  result.rejected = std::move(items.rejected);
  return result;
}

absl::StatusOr<AdjustBundleResult> MakeResult(const v1::AdjustBundleResponse::Header& header,
                                              ResultItems items) {
  AdjustBundleResult result;
  result.base_revision = header.base_revision();
  ASSIGN_OR_RETURN(result.keyframes, ReadCount("keyframes", header.keyframes()));
  ASSIGN_OR_RETURN(result.points, ReadCount("points", header.points()));
  ASSIGN_OR_RETURN(result.iterations, ReadCount("iterations", header.iterations()));
  result.initial_cost = header.initial_cost();
  result.final_cost = header.final_cost();
  result.seconds = header.seconds();
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(header.local_maps()));
  ASSIGN_OR_RETURN(result.redundant, slots.Keyframes(header.redundant(), "redundant"));
  result.poses = std::move(items.poses);
  result.positions = std::move(items.positions);
  result.rejected = std::move(items.rejected);
  return result;
}

}  // namespace corbslam::services
