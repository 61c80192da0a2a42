#include "client_agent/source/frame_reader.h"

#include <opencv2/core.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/first_camera_reader.h"
#include "client_agent/source/layout_hints.h"
#include "client_agent/source/perturb.h"
#include "client_agent/source/scaled_reader.h"
#include "client_agent/source/without_imu.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::StatusOr<std::unique_ptr<FrameReader>> OpenLayout(const SourceSpec& spec) {
  switch (spec.layout) {
    case SourceLayout::kKitti:
      return OpenKitti(spec);
    case SourceLayout::kEuroc:
      return OpenEuroc(spec);
    case SourceLayout::kTum:
      return OpenTum(spec);
    case SourceLayout::kSevenScenes:
      return OpenSevenScenes(spec);
    case SourceLayout::kRegistered:
      break;
  }
  return absl::InvalidArgumentError("unknown source layout");
}

}  // namespace

absl::StatusOr<SensorImages> ReadPerturbed(const FrameReader& reader, size_t frame,
                                           const Perturbation& perturbation) {
  ASSIGN_OR_RETURN(SensorImages images, reader.Read(frame));
  RETURN_IF_ERROR(PerturbImages(perturbation, frame, images));
  return images;
}

namespace {

absl::StatusOr<std::unique_ptr<FrameReader>> OpenAnyReader(const SourceSpec& spec) {
  if (spec.settings != nullptr) return spec.settings->Open();
  absl::StatusOr<std::unique_ptr<FrameReader>> reader = OpenLayout(spec);
  if (!reader.ok()) return WithLayoutHint(reader.status(), spec);
  if (spec.opening.scale == 1) return reader;
  return ScaleReader(*std::move(reader), spec.opening.scale);
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenReader(const SourceSpec& spec) {
  ASSIGN_OR_RETURN(std::unique_ptr<FrameReader> reader, OpenAnyReader(spec));
  if (spec.one_camera) reader = FirstCameraAlone(std::move(reader));
  if (!spec.selection.reverse) return reader;
  return WithoutImu(std::move(reader),
                    "the frames are played backwards (reverse), an IMU's samples can't be");
}

}  // namespace corbslam::client_agent
