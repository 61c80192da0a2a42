#include <utility>
#include <vector>

#include "services/convert/ids.h"
#include "services/convert/overlap.h"
#include "services/convert/parts.h"
#include "services/convert/work/work.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kOverlapBytes = 160;
constexpr size_t kPairBytes = 24;

// Adds the chunk to exactly one of two readers.
absl::Status AddToView(const v1::MapChunk& chunk, MapViewReader& first, MapViewReader& second) {
  if (chunk.view() == v1::MAP_VIEW_FIRST) return first.Add(chunk);
  if (chunk.view() == v1::MAP_VIEW_SECOND) return second.Add(chunk);
  return OutOfRange("view", static_cast<int>(chunk.view()), 1, 2);
}

bool WriteOverlaps(const std::vector<Overlap>& overlaps, const ChunkSink& sink) {
  PartWriter<v1::MapChunk> writer(kChunkTargetBytes, [](v1::MapChunk& chunk) {
    chunk.set_view(v1::MAP_VIEW_FIRST);
    return SlotWriter(chunk.mutable_local_maps());
  });
  for (const Overlap& overlap : overlaps) {
    writer.Reserve(kOverlapBytes + overlap.inliers.size() * kPairBytes);
    ToProto(overlap, writer.slots(), writer.part().add_overlaps());
  }
  for (const v1::MapChunk& chunk : std::move(writer).Take()) {
    if (!sink(chunk.SerializeAsString())) return false;
  }
  return true;
}

}  // namespace

v1::VerifyOverlapRequest::Header HeaderOf(const VerifyOverlapRequest& request) {
  v1::VerifyOverlapRequest::Header header;
  SlotWriter slots(header.mutable_local_maps());
  header.set_base_revision(request.base_revision);
  header.set_fix_scale(request.fix_scale);
  slots.Write(request.query, header.mutable_query());
  for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
    auto* proto = header.add_candidates();
    slots.Write(candidate.id, proto->mutable_id());
    proto->set_shared_words(static_cast<uint32_t>(std::max(candidate.shared_words, 0)));
  }
  return header;
}

v1::FuseMapsRequest::Header HeaderOf(const FuseMapsRequest& request) {
  v1::FuseMapsRequest::Header header;
  header.set_base_revision(request.base_revision);
  header.set_fix_scale(request.fix_scale);
  for (const size_t index : request.new_overlaps) {
    header.add_new_overlaps(static_cast<uint32_t>(index));
  }
  return header;
}

v1::AdjustBundleRequest::Header HeaderOf(const AdjustBundleRequest& request) {
  v1::AdjustBundleRequest::Header header;
  SlotWriter slots(header.mutable_local_maps());
  header.set_base_revision(request.base_revision);
  IdColumnWriter fixed(slots, header.mutable_fixed());
  for (const KeyframeId id : request.fixed) fixed.Add(id);
  header.set_max_iterations(static_cast<uint32_t>(std::max(request.max_iterations, 0)));
  header.set_threads(static_cast<uint32_t>(std::max(request.threads, 0)));
  header.set_redundant_share(request.redundant_share);
  header.set_target_keyframes(static_cast<uint32_t>(request.target_keyframes));
  return header;
}

bool WriteChunks(const VerifyOverlapRequest& request, const ChunkSink& sink) {
  return WriteMapView(*request.query_view, v1::MAP_VIEW_FIRST, {}, sink) &&
         WriteMapView(request.candidate_view, v1::MAP_VIEW_SECOND, {.all_keypoints = false}, sink);
}

bool WriteChunks(const FuseMapsRequest& request, const ChunkSink& sink) {
  const MapViewContent content = {.all_keypoints = false, .covisibility = true};
  return WriteMapView(request.target, v1::MAP_VIEW_FIRST, content, sink) &&
         WriteMapView(request.source, v1::MAP_VIEW_SECOND, content, sink) &&
         WriteOverlaps(request.overlaps, sink);
}

bool WriteChunks(const AdjustBundleRequest& request, const ChunkSink& sink) {
  return WriteMapView(request.view, v1::MAP_VIEW_FIRST,
                      {.descriptors = false, .all_keypoints = false}, sink);
}

absl::Status VerifyOverlapRequestReader::AddHeader(const v1::VerifyOverlapRequest::Header& header) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(header.local_maps()));
  request_.base_revision = header.base_revision();
  request_.fix_scale = header.fix_scale();
  ASSIGN_OR_RETURN(request_.query, slots.Keyframe(header.query()));
  if (header.candidates_size() < 1 || header.candidates_size() > kMaxCandidates) {
    return OutOfRange("number of candidates", header.candidates_size(), 1, kMaxCandidates);
  }
  for (const auto& entry : header.candidates()) {
    VerifyOverlapRequest::Candidate candidate;
    ASSIGN_OR_RETURN(candidate.id, slots.Keyframe(entry.id()));
    if (entry.shared_words() > 0x7fffffffu) {
      return OutOfRange("shared_words", entry.shared_words(), 0u, 0x7fffffffu);
    }
    candidate.shared_words = static_cast<int>(entry.shared_words());
    request_.candidates.push_back(candidate);
  }
  return absl::OkStatus();
}

absl::Status VerifyOverlapRequestReader::AddChunk(const v1::MapChunk& chunk) {
  return AddToView(chunk, query_view_, candidate_view_);
}

absl::StatusOr<VerifyOverlapRequest> VerifyOverlapRequestReader::Finish() {
  if (query_view_.map().FindKeyframe(request_.query) == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("query ", ToString(request_.query), " is not in the first view"));
  }
  for (const auto& candidate : request_.candidates) {
    if (candidate_view_.map().FindKeyframe(candidate.id) == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("candidate ", ToString(candidate.id), " is not in the second view"));
    }
  }
  request_.query_view = std::make_shared<const Map>(std::move(query_view_).Take());
  request_.candidate_view = std::move(candidate_view_).Take();
  return std::move(request_);
}

absl::Status FuseMapsRequestReader::AddHeader(const v1::FuseMapsRequest::Header& header) {
  request_.base_revision = header.base_revision();
  request_.fix_scale = header.fix_scale();
  request_.new_overlaps.assign(header.new_overlaps().begin(), header.new_overlaps().end());
  return absl::OkStatus();
}

absl::Status FuseMapsRequestReader::AddChunk(const v1::MapChunk& chunk) {
  RETURN_IF_ERROR(AddToView(chunk, target_, source_));
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(chunk.local_maps()));
  for (const v1::VerifiedOverlap& entry : chunk.overlaps()) {
    ASSIGN_OR_RETURN(Overlap overlap, FromProto(entry, slots));
    request_.overlaps.push_back(std::move(overlap));
  }
  return absl::OkStatus();
}

absl::StatusOr<FuseMapsRequest> FuseMapsRequestReader::Finish() {
  for (const size_t index : request_.new_overlaps) {
    if (index < request_.overlaps.size()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("new_overlaps names ", index, " of ", request_.overlaps.size(), " overlaps"));
  }
  request_.target = std::move(target_).Take();
  request_.source = std::move(source_).Take();
  return std::move(request_);
}

absl::Status AdjustBundleRequestReader::AddHeader(const v1::AdjustBundleRequest::Header& header) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(header.local_maps()));
  request_.base_revision = header.base_revision();
  ASSIGN_OR_RETURN(request_.fixed, slots.Keyframes(header.fixed(), "fixed"));
  if (request_.fixed.empty()) return absl::InvalidArgumentError("fixed names no keyframe");
  if (header.max_iterations() < 1 || header.max_iterations() > kMaxIterations) {
    return OutOfRange("max_iterations", header.max_iterations(), 1, kMaxIterations);
  }
  if (header.threads() > kMaxSolverThreads) {
    return OutOfRange("threads", header.threads(), 0, kMaxSolverThreads);
  }
  if (!(header.redundant_share() >= 0 && header.redundant_share() <= 1)) {
    return OutOfRange("redundant_share", header.redundant_share(), 0, 1);
  }
  request_.redundant_share = header.redundant_share();
  request_.target_keyframes = header.target_keyframes();
  request_.max_iterations = static_cast<int>(header.max_iterations());
  request_.threads = std::max(1, static_cast<int>(header.threads()));
  return absl::OkStatus();
}

absl::Status AdjustBundleRequestReader::AddChunk(const v1::MapChunk& chunk) {
  if (chunk.view() != v1::MAP_VIEW_FIRST) {
    return OutOfRange("view", static_cast<int>(chunk.view()), 1, 1);
  }
  return view_.Add(chunk);
}

absl::StatusOr<AdjustBundleRequest> AdjustBundleRequestReader::Finish() {
  for (const KeyframeId id : request_.fixed) {
    if (view_.map().FindKeyframe(id) != nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("fixed names ", ToString(id), ", which is not in the view"));
  }
  request_.view = std::move(view_).Take();
  return std::move(request_);
}

}  // namespace corbslam::services
