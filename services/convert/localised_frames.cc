#include "services/convert/localised_frames.h"

#include "absl/strings/str_cat.h"
#include "services/convert/errors.h"
#include "services/convert/features.h"
#include "services/convert/geometry.h"
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

}  // namespace

void ToProto(std::span<const LocalisedFrame> frames, v1::LocalisedFrames* proto) {
  for (const LocalisedFrame& frame : frames) {
    v1::LocalisedFrame* written = proto->add_frames();
    written->set_timestamp_ns(frame.timestamp_ns);
    if (!frame.camera_from_global.has_value()) continue;
    ToProto(*frame.camera_from_global, written->mutable_camera_from_global());
  }
}

absl::StatusOr<std::vector<LocalisedFrame>> FromProto(const v1::LocalisedFrames& proto) {
  if (proto.frames_size() > kMaxLocalisedFrames) {
    return OutOfRange("number of localised.frames", proto.frames_size(), 0, kMaxLocalisedFrames);
  }
  std::vector<LocalisedFrame> frames;
  frames.reserve(static_cast<size_t>(proto.frames_size()));
  for (int i = 0; i < proto.frames_size(); ++i) {
    absl::StatusOr<LocalisedFrame> frame = ReadFrame(proto.frames(i));
    if (!frame.ok()) return Locate(frame.status(), absl::StrCat("localised.frames[", i, "]"));
    frames.push_back(*std::move(frame));
  }
  return frames;
}

}  // namespace corbslam::services
