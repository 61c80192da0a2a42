// Converts the search for a picture's place, and the look at a picture, to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_WORK_LOCATE_FRAME_H_
#define CORBSLAM_SERVICES_CONVERT_WORK_LOCATE_FRAME_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "services/convert/work/map_view.h"
#include "services/convert/work/result_items.h"
#include "slam/exchange/frame_location.h"

namespace corbslam::services {

// Collects what is read of a request; as the readers in work.h.
class LocateFrameRequestReader {
 public:
  absl::Status AddHeader(const v1::LocateFrameRequest::Header& header);
  absl::Status AddChunk(const v1::MapChunk& chunk);
  absl::StatusOr<LocateFrameRequest> Finish();

 private:
  LocateFrameRequest request_;
  MapViewReader view_{/*descriptors_optional=*/false, Covisibility::kCounted};
};

v1::LocateFrameRequest::Header HeaderOf(const LocateFrameRequest& request);
v1::LocateFrameResponse::Header HeaderOf(const LocateFrameResult& result);
bool WriteChunks(const LocateFrameRequest& request, const ChunkSink& sink);
// Writes nothing: all of the result is in its header.
bool WriteChunks(const LocateFrameResult& result, const ChunkSink& sink);
absl::StatusOr<LocateFrameResult> MakeResult(const v1::LocateFrameResponse::Header& header,
                                             const ResultItems& items);

v1::LocateStage ToProto(LocateStage stage);
// INVALID_ARGUMENT for an unknown value, or none.
absl::StatusOr<LocateStage> FromProto(v1::LocateStage stage);

// Writes 36 numbers, row by row; nothing for none.
void ToProto(const std::optional<Matrix6d>& covariance,
             google::protobuf::RepeatedField<double>* proto);
// INVALID_ARGUMENT for another count than 0 or 36, or for what is not finite.
absl::StatusOr<std::optional<Matrix6d>> PoseCovarianceFromProto(
    const google::protobuf::RepeatedField<double>& covariance);

// INVALID_ARGUMENT names the field: no bytes, more than 3 MiB, an impossible camera, or one that
// says how it was rectified.
absl::StatusOr<ExtractFeaturesRequest> FromProto(const v1::Picture& picture);
void ToProto(const ExtractFeaturesRequest& request, v1::Picture* picture);
// A picture's features, as a keyframe without a place: INVALID_ARGUMENT names the field.
absl::StatusOr<Keyframe> FrameFromProto(const v1::Camera& camera, const v1::Features& features);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_WORK_LOCATE_FRAME_H_
