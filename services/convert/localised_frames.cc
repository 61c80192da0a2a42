#include "services/convert/localised_frames.h"

#include "absl/strings/str_cat.h"
#include "services/convert/columns.h"
#include "services/convert/errors.h"
#include "services/convert/features.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::StatusOr<LocalisedFrame> ReadFrame(const v1::LocalisedFrame& proto) {
  LocalisedFrame frame;
  frame.timestamp_ns = proto.timestamp_ns();
  RETURN_IF_ERROR(CheckTimestamp(frame.timestamp_ns));
  if (proto.has_camera_from_global()) {
    ASSIGN_OR_RETURN(frame.camera_from_global, FromProto(proto.camera_from_global()));
  }
  return frame;
}

// Reads what there is to keep.
absl::Status ReadPart(const v1::LocalisedFrames& proto, LocalisedFrames& localised) {
  localised.number = proto.number();
  if (localised.number == 0) return absl::InvalidArgumentError("number is 0, must be 1 or more");
  const int frames =
      proto.tracked_frames().timestamp_deltas_ns_size() + proto.lost_frame_deltas_ns_size();
  if (frames > kMaxLocalisedFrames) {
    return OutOfRange("number of tracked and lost frames", frames, 0, kMaxLocalisedFrames);
  }
  if (proto.has_recorded_camera()) {
    ASSIGN_OR_RETURN(localised.recorded_camera, FromProto(proto.recorded_camera()));
  }
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(proto.local_maps()));
  ASSIGN_OR_RETURN(localised.tracked_frames, ReadFrames(proto.tracked_frames(), slots));
  ASSIGN_OR_RETURN(localised.lost_frames_ns,
                   ReadTimes(proto.lost_frame_deltas_ns(), "lost_frame_deltas_ns"));
  return absl::OkStatus();
}

}  // namespace

void ToProto(const LocalisedFrames& localised, v1::LocalisedFrames* proto) {
  for (const LocalisedFrame& frame : localised.frames) {
    v1::LocalisedFrame* written = proto->add_frames();
    written->set_timestamp_ns(frame.timestamp_ns);
    if (!frame.camera_from_global.has_value()) continue;
    ToProto(*frame.camera_from_global, written->mutable_camera_from_global());
  }
  if (localised.run == 0) return;
  proto->set_run(localised.run);
  proto->set_number(localised.number);
  if (localised.recorded_camera.has_value()) {
    ToProto(*localised.recorded_camera, proto->mutable_recorded_camera());
  }
  SlotWriter slots(proto->mutable_local_maps());
  WriteFrames(localised.tracked_frames, slots, proto->mutable_tracked_frames());
  WriteTimes(localised.lost_frames_ns, proto->mutable_lost_frame_deltas_ns());
}

absl::StatusOr<LocalisedFrames> FromProto(const v1::LocalisedFrames& proto) {
  if (proto.frames_size() > kMaxLocalisedFrames) {
    return OutOfRange("number of localised.frames", proto.frames_size(), 0, kMaxLocalisedFrames);
  }
  LocalisedFrames localised;
  localised.frames.reserve(static_cast<size_t>(proto.frames_size()));
  for (int i = 0; i < proto.frames_size(); ++i) {
    absl::StatusOr<LocalisedFrame> frame = ReadFrame(proto.frames(i));
    if (!frame.ok()) return Locate(frame.status(), absl::StrCat("localised.frames[", i, "]"));
    localised.frames.push_back(*std::move(frame));
  }
  localised.run = proto.run();
  if (localised.run == 0) return localised;
  RETURN_IF_ERROR(Locate(ReadPart(proto, localised),
                         absl::StrCat("localised, part ", proto.number(), " of run ",
                                      ToString(LocalMapId{localised.run}))));
  return localised;
}

}  // namespace corbslam::services
