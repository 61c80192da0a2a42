#include "client_agent/source/image_source.h"

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/perturb.h"
#include "client_agent/source/read_ahead.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Pictures that are decoded and not yet taken: enough to even out the disk, little memory.
constexpr size_t kReadAheadFrames = 3;

class RecordedSource : public ImageSource {
 public:
  RecordedSource(std::unique_ptr<FrameReader> reader, std::vector<size_t> frames,
                 const Perturbation& perturbation)
      : reader_(std::move(reader)),
        frames_(std::move(frames)),
        perturbation_(perturbation),
        read_ahead_(frames_.size(), kReadAheadFrames, [this](size_t i) {
          return ReadPerturbed(*reader_, frames_[i], perturbation_);
        }) {}

  const SensorCalibration& calibration() const override { return reader_->calibration(); }
  size_t size() const override { return frames_.size(); }
  SourceFrame frame(size_t i) const override {
    return {frames_[i], reader_->timestamp_ns(frames_[i])};
  }
  absl::StatusOr<std::optional<SensorImages>> Next() override { return read_ahead_.Next(); }

 private:
  const std::unique_ptr<FrameReader> reader_;
  const std::vector<size_t> frames_;
  const Perturbation perturbation_;
  ReadAhead read_ahead_;  // Last: its thread uses the others.
};

}  // namespace

absl::StatusOr<SensorImages> ReadPerturbed(const FrameReader& reader, size_t frame,
                                           const Perturbation& perturbation) {
  ASSIGN_OR_RETURN(SensorImages images, reader.Read(frame));
  try {
    images.grey = Perturb(images.grey, perturbation, 2 * frame);
    if (!images.right.empty()) images.right = Perturb(images.right, perturbation, 2 * frame + 1);
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("frame ", frame, ": ", exception.what()));
  }
  return images;
}

absl::StatusOr<std::unique_ptr<FrameReader>> OpenReader(const SourceSpec& spec) {
  switch (spec.layout) {
    case SourceLayout::kKitti:
      return OpenKitti(spec.directory);
    case SourceLayout::kEuroc:
      return OpenEuroc(spec.directory);
    case SourceLayout::kTum:
      return OpenTum(spec.directory);
    case SourceLayout::kSim:
      return OpenSimulation(spec.simulation);
  }
  return absl::InvalidArgumentError("unknown source layout");
}

absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(const SourceSpec& spec) {
  ASSIGN_OR_RETURN(std::unique_ptr<FrameReader> reader, OpenReader(spec));
  std::vector<size_t> frames = FramesOf(spec, reader->frame_count());
  if (frames.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "source ", FormatSourceSpec(spec), " selects none of ", reader->frame_count(), " frames"));
  }
  return std::make_unique<RecordedSource>(std::move(reader), std::move(frames), spec.perturbation);
}

absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(absl::string_view spec) {
  ASSIGN_OR_RETURN(const SourceSpec parsed, ParseSourceSpec(spec));
  return OpenSource(parsed);
}

}  // namespace corbslam
