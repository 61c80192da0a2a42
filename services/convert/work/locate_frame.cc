#include "services/convert/work/locate_frame.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/lens.h"
#include "services/convert/limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr uint32_t kMaxCount = 0x7fffffffu;
constexpr int kCovarianceNumbers = 36;

uint32_t Count(int value) { return static_cast<uint32_t>(std::max(value, 0)); }

// On the wire a stage that came later has the larger number.
struct StageOnTheWire {
  LocateStage stage;
  v1::LocateStage proto;
};
constexpr StageOnTheWire kStages[] = {
    {LocateStage::kFewFeatures, v1::LOCATE_STAGE_FEW_FEATURES},
    {LocateStage::kNoCandidates, v1::LOCATE_STAGE_NO_CANDIDATES},
    {LocateStage::kFewMatches, v1::LOCATE_STAGE_FEW_MATCHES},
    {LocateStage::kNoPose, v1::LOCATE_STAGE_NO_POSE},
    {LocateStage::kFewInliers, v1::LOCATE_STAGE_FEW_INLIERS},
    {LocateStage::kCameraInDoubt, v1::LOCATE_STAGE_CAMERA_IN_DOUBT},
    {LocateStage::kOutsidePrior, v1::LOCATE_STAGE_OUTSIDE_PRIOR},
    {LocateStage::kLocated, v1::LOCATE_STAGE_LOCATED}};

absl::StatusOr<int> CountFromProto(absl::string_view field, uint32_t value) {
  if (value > kMaxCount) return OutOfRange(field, value, 0u, kMaxCount);
  return static_cast<int>(value);
}

}  // namespace

v1::LocateStage ToProto(LocateStage stage) {
  const auto* entry = std::ranges::find(kStages, stage, &StageOnTheWire::stage);
  return entry == std::end(kStages) ? v1::LOCATE_STAGE_UNSPECIFIED : entry->proto;
}

absl::StatusOr<LocateStage> FromProto(v1::LocateStage stage) {
  const auto* entry = std::ranges::find(kStages, stage, &StageOnTheWire::proto);
  if (entry != std::end(kStages)) return entry->stage;
  return OutOfRange("stage", static_cast<int>(stage), 1, static_cast<int>(std::size(kStages)));
}

void ToProto(const std::optional<Matrix6d>& covariance,
             google::protobuf::RepeatedField<double>* proto) {
  if (!covariance.has_value()) return;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) proto->Add((*covariance)(row, column));
  }
}

absl::StatusOr<std::optional<Matrix6d>> PoseCovarianceFromProto(
    const google::protobuf::RepeatedField<double>& covariance) {
  if (covariance.empty()) return std::nullopt;
  if (covariance.size() != kCovarianceNumbers) {
    return BadLength("covariance", covariance.size(), kCovarianceNumbers);
  }
  Matrix6d matrix;
  for (int i = 0; i < kCovarianceNumbers; ++i) matrix(i / 6, i % 6) = covariance.Get(i);
  if (!matrix.allFinite()) return absl::InvalidArgumentError("covariance is not finite");
  return matrix;
}

absl::StatusOr<ExtractFeaturesRequest> FromProto(const v1::Picture& picture) {
  if (picture.encoded().empty() || picture.encoded().size() > kMaxPictureBytes) {
    return OutOfRange("size of picture.encoded in bytes", picture.encoded().size(), size_t{1},
                      kMaxPictureBytes);
  }
  if (picture.camera().has_camera_from_recorded()) {
    return absl::InvalidArgumentError(
        "picture.camera.camera_from_recorded is set: give the picture as it was recorded");
  }
  ExtractFeaturesRequest request;
  absl::StatusOr<RecordedCamera> recorded = FromProto(picture.camera());
  RETURN_IF_ERROR(Locate(recorded.status(), "picture.camera"));
  request.encoded = picture.encoded();
  request.camera = recorded->lens;
  return request;
}

void ToProto(const ExtractFeaturesRequest& request, v1::Picture* picture) {
  picture->set_encoded(request.encoded);
  v1::RecordedCamera& camera = *picture->mutable_camera();
  camera.set_fx_px(request.camera.fx_px);
  camera.set_fy_px(request.camera.fy_px);
  camera.set_cx_px(request.camera.cx_px);
  camera.set_cy_px(request.camera.cy_px);
  LensToProto(request.camera.lens, &camera);
}

absl::StatusOr<Keyframe> FrameFromProto(const v1::Camera& camera, const v1::Features& features) {
  absl::StatusOr<Camera> read = FromProto(camera);
  RETURN_IF_ERROR(Locate(read.status(), "camera"));
  absl::StatusOr<Features> found = FromProto(features, *read);
  RETURN_IF_ERROR(Locate(found.status(), "features"));
  if (!read->IsMetric() && std::ranges::any_of(found->keypoints, &Keypoint::HasDepth)) {
    return absl::InvalidArgumentError(
        "camera.baseline_m is 0, and features.disparity_px128 has disparities: these need the "
        "baseline of the pair; leave them out for a single camera");
  }
  Keyframe frame;
  frame.payload =
      MakeKeyframePayload({}, 0, 0, std::make_shared<const Camera>(*read), *std::move(found));
  frame.points.resize(frame.keypoints().size());
  frame.words = ReadNodes(features);
  return frame;
}

v1::LocateFrameRequest::Header HeaderOf(const LocateFrameRequest& request) {
  v1::LocateFrameRequest::Header header;
  SlotWriter slots(header.mutable_local_maps());
  header.set_base_revision(request.base_revision);
  ToProto(request.frame.camera(), header.mutable_camera());
  ToProto(request.frame.payload->features, header.mutable_features());
  if (request.frame.words != nullptr) WriteNodes(*request.frame.words, header.mutable_features());
  for (const LocateFrameRequest::Candidate& candidate : request.candidates) {
    auto* proto = header.add_candidates();
    slots.Write(candidate.id, proto->mutable_id());
    proto->set_shared_words(Count(candidate.shared_words));
  }
  return header;
}

bool WriteChunks(const LocateFrameRequest& request, const ChunkSink& sink) {
  return WriteMapView(request.view, v1::MAP_VIEW_FIRST, {.all_keypoints = false}, sink);
}

absl::Status LocateFrameRequestReader::AddHeader(const v1::LocateFrameRequest::Header& header) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(header.local_maps()));
  request_.base_revision = header.base_revision();
  ASSIGN_OR_RETURN(request_.frame, FrameFromProto(header.camera(), header.features()));
  if (header.candidates_size() < 1 || header.candidates_size() > kMaxCandidates) {
    return OutOfRange("number of candidates", header.candidates_size(), 1, kMaxCandidates);
  }
  for (const auto& entry : header.candidates()) {
    LocateFrameRequest::Candidate candidate;
    ASSIGN_OR_RETURN(candidate.id, slots.Keyframe(entry.id()));
    ASSIGN_OR_RETURN(candidate.shared_words, CountFromProto("shared_words", entry.shared_words()));
    request_.candidates.push_back(candidate);
  }
  return absl::OkStatus();
}

absl::Status LocateFrameRequestReader::AddChunk(const v1::MapChunk& chunk) {
  if (chunk.view() != v1::MAP_VIEW_FIRST) {
    return OutOfRange("view", static_cast<int>(chunk.view()), 1, 1);
  }
  return view_.Add(chunk);
}

absl::StatusOr<LocateFrameRequest> LocateFrameRequestReader::Finish() {
  for (const LocateFrameRequest::Candidate& candidate : request_.candidates) {
    if (view_.map().FindKeyframe(candidate.id) != nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("candidate ", ToString(candidate.id), " is not in the view"));
  }
  request_.view = std::move(view_).Take();
  return std::move(request_);
}

v1::LocateFrameResponse::Header HeaderOf(const LocateFrameResult& result) {
  v1::LocateFrameResponse::Header header;
  header.set_base_revision(result.base_revision);
  header.set_stage(ToProto(result.stage));
  header.set_word_matches(Count(result.word_matches));
  header.set_pose_inliers(Count(result.pose_inliers));
  header.set_inliers(Count(result.inliers));
  header.set_inliers_needed(Count(result.inliers_needed));
  header.set_visible_points(Count(result.visible_points));
  header.set_chance_inliers(Count(result.chance_inliers));
  if (result.fitting_camera.has_value()) {
    ToProto(*result.fitting_camera, header.mutable_fitting_camera());
  }
  if (result.stage != LocateStage::kLocated) return header;
  ToProto(result.camera_from_map, header.mutable_camera_from_map());
  ToProto(result.covariance, header.mutable_covariance());
  SlotWriter slots(header.mutable_local_maps());
  IdColumnWriter keyframes(slots, header.mutable_keyframes());
  for (const KeyframeId& id : result.keyframes) keyframes.Add(id);
  return header;
}

bool WriteChunks(const LocateFrameResult& /*result*/, const ChunkSink& /*sink*/) { return true; }

absl::StatusOr<LocateFrameResult> MakeResult(const v1::LocateFrameResponse::Header& header,
                                             const ResultItems& /*items*/) {
  LocateFrameResult result;
  result.base_revision = header.base_revision();
  ASSIGN_OR_RETURN(result.stage, FromProto(header.stage()));
  ASSIGN_OR_RETURN(result.word_matches, CountFromProto("word_matches", header.word_matches()));
  ASSIGN_OR_RETURN(result.pose_inliers, CountFromProto("pose_inliers", header.pose_inliers()));
  ASSIGN_OR_RETURN(result.inliers, CountFromProto("inliers", header.inliers()));
  ASSIGN_OR_RETURN(result.inliers_needed,
                   CountFromProto("inliers_needed", header.inliers_needed()));
  ASSIGN_OR_RETURN(result.visible_points,
                   CountFromProto("visible_points", header.visible_points()));
  ASSIGN_OR_RETURN(result.chance_inliers,
                   CountFromProto("chance_inliers", header.chance_inliers()));
  if (header.has_fitting_camera()) {
    ASSIGN_OR_RETURN(result.fitting_camera, FromProto(header.fitting_camera()));
  }
  if (result.stage != LocateStage::kLocated) return result;
  ASSIGN_OR_RETURN(result.camera_from_map, FromProto(header.camera_from_map()));
  ASSIGN_OR_RETURN(result.covariance, PoseCovarianceFromProto(header.covariance()));
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(header.local_maps()));
  ASSIGN_OR_RETURN(result.keyframes, slots.Keyframes(header.keyframes(), "keyframes"));
  return result;
}

}  // namespace corbslam::services
