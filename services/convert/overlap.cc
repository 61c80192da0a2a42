#include "services/convert/overlap.h"

#include <limits>
#include <utility>
#include <vector>

#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr uint32_t kMaxCount = std::numeric_limits<int>::max();

constexpr std::pair<OverlapVerdict, v1::OverlapVerdict> kVerdicts[] = {
    {OverlapVerdict::kAccepted, v1::OVERLAP_VERDICT_ACCEPTED},
    {OverlapVerdict::kTooFewWordMatches, v1::OVERLAP_VERDICT_TOO_FEW_WORD_MATCHES},
    {OverlapVerdict::kTooFewRansacInliers, v1::OVERLAP_VERDICT_TOO_FEW_RANSAC_INLIERS},
    {OverlapVerdict::kTooFewRefinedInliers, v1::OVERLAP_VERDICT_TOO_FEW_REFINED_INLIERS},
    {OverlapVerdict::kTooFewProjectedMatches, v1::OVERLAP_VERDICT_TOO_FEW_PROJECTED_MATCHES},
    {OverlapVerdict::kNoSecondKeyframe, v1::OVERLAP_VERDICT_NO_SECOND_KEYFRAME},
    {OverlapVerdict::kWrongScale, v1::OVERLAP_VERDICT_WRONG_SCALE},
    {OverlapVerdict::kBendsGraph, v1::OVERLAP_VERDICT_BENDS_GRAPH},
    {OverlapVerdict::kTakenBack, v1::OVERLAP_VERDICT_TAKEN_BACK},
};

}  // namespace

v1::OverlapVerdict ToProto(OverlapVerdict verdict) {
  for (const auto& [plain, proto] : kVerdicts) {
    if (plain == verdict) return proto;
  }
  return v1::OVERLAP_VERDICT_UNSPECIFIED;
}

absl::StatusOr<OverlapVerdict> FromProto(v1::OverlapVerdict verdict) {
  for (const auto& [plain, proto] : kVerdicts) {
    if (proto == verdict) return plain;
  }
  return OutOfRange("verdict", static_cast<int>(verdict), 1,
                    static_cast<int>(v1::OverlapVerdict_MAX));
}

void ToProto(const OverlapEvidence& evidence, v1::OverlapEvidence* proto) {
  const auto count = [](int value) { return static_cast<uint32_t>(std::max(value, 0)); };
  proto->set_shared_words(count(evidence.shared_words));
  proto->set_word_matches(count(evidence.word_matches));
  proto->set_ransac_inliers(count(evidence.ransac_inliers));
  proto->set_guided_matches(count(evidence.guided_matches));
  proto->set_refined_inliers(count(evidence.refined_inliers));
  proto->set_projected_matches(count(evidence.projected_matches));
  proto->set_consistent_keyframes(count(evidence.consistent_keyframes));
  proto->set_chance_matches(count(evidence.chance_matches));
  proto->set_visible_points(count(evidence.visible_points));
}

absl::StatusOr<OverlapEvidence> FromProto(const v1::OverlapEvidence& proto) {
  for (const uint32_t value :
       {proto.shared_words(), proto.word_matches(), proto.ransac_inliers(), proto.guided_matches(),
        proto.refined_inliers(), proto.projected_matches(), proto.consistent_keyframes(),
        proto.chance_matches(), proto.visible_points()}) {
    if (value > kMaxCount) return OutOfRange("a count of the evidence", value, 0u, kMaxCount);
  }
  return OverlapEvidence{
      .shared_words = static_cast<int>(proto.shared_words()),
      .word_matches = static_cast<int>(proto.word_matches()),
      .ransac_inliers = static_cast<int>(proto.ransac_inliers()),
      .guided_matches = static_cast<int>(proto.guided_matches()),
      .refined_inliers = static_cast<int>(proto.refined_inliers()),
      .projected_matches = static_cast<int>(proto.projected_matches()),
      .visible_points = static_cast<int>(proto.visible_points()),
      .chance_matches = static_cast<int>(proto.chance_matches()),
      .consistent_keyframes = static_cast<int>(proto.consistent_keyframes()),
  };
}

void ToProto(const Overlap& overlap, SlotWriter& slots, v1::VerifiedOverlap* proto) {
  slots.Write(overlap.query, proto->mutable_query());
  slots.Write(overlap.candidate, proto->mutable_candidate());
  ToProto(overlap.candidate_from_query, proto->mutable_candidate_from_query());
  ToProto(overlap.covariance, proto->mutable_covariance());
  IdColumnWriter query_points(slots, proto->mutable_query_points());
  IdColumnWriter candidate_points(slots, proto->mutable_candidate_points());
  for (const PointPair& pair : overlap.inliers) {
    query_points.Add(pair.query);
    candidate_points.Add(pair.candidate);
  }
  ToProto(overlap.evidence, proto->mutable_evidence());
  proto->set_verdict(ToProto(overlap.verdict));
}

absl::StatusOr<Overlap> FromProto(const v1::VerifiedOverlap& proto, const SlotReader& slots) {
  Overlap overlap;
  ASSIGN_OR_RETURN(overlap.query, slots.Keyframe(proto.query()));
  ASSIGN_OR_RETURN(overlap.candidate, slots.Keyframe(proto.candidate()));
  if (!overlap.query.IsValid() || !overlap.candidate.IsValid()) {
    return absl::InvalidArgumentError("an overlap must name two keyframes");
  }
  ASSIGN_OR_RETURN(overlap.candidate_from_query, FromProto(proto.candidate_from_query()));
  ASSIGN_OR_RETURN(overlap.covariance, FromProto(proto.covariance()));
  ASSIGN_OR_RETURN(const std::vector<MapPointId> query,
                   slots.Points(proto.query_points(), "query_points"));
  ASSIGN_OR_RETURN(const std::vector<MapPointId> candidate,
                   slots.Points(proto.candidate_points(), "candidate_points"));
  if (query.size() != candidate.size()) {
    return BadLength("candidate_points", static_cast<int64_t>(candidate.size()),
                     static_cast<int64_t>(query.size()));
  }
  for (size_t i = 0; i < query.size(); ++i) overlap.inliers.push_back({query[i], candidate[i]});
  ASSIGN_OR_RETURN(overlap.evidence, FromProto(proto.evidence()));
  ASSIGN_OR_RETURN(overlap.verdict, FromProto(proto.verdict()));
  return overlap;
}

}  // namespace corbslam::services
