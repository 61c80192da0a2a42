#include "client_agent/source/image_source.h"

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/layout_hints.h"
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
    return {frames_[i], reader_->timestamp_ns(frames_[i]), reader_->drive(frames_[i])};
  }
  absl::StatusOr<std::optional<SensorImages>> Next() override;
  size_t position() const override { return next_ - 1; }
  LeftOutFrames left_out() const override { return left_out_; }

 private:
  const std::unique_ptr<FrameReader> reader_;
  const std::vector<size_t> frames_;
  const Perturbation perturbation_;
  size_t next_ = 0;  // The frame that read_ahead_ gives next.
  size_t unreadable_in_a_row_ = 0;
  LeftOutFrames left_out_;
  ReadAhead read_ahead_;  // Last: its thread uses the others.
};

absl::StatusOr<std::optional<SensorImages>> RecordedSource::Next() {
  while (next_ < frames_.size()) {
    absl::StatusOr<std::optional<SensorImages>> images = read_ahead_.Next();
    if (images.ok() && !images->has_value()) return std::nullopt;
    ++next_;
    if (images.ok()) {
      unreadable_in_a_row_ = 0;
      return images;
    }
    ++left_out_.count;
    left_out_.last = std::string(images.status().message());
    if (++unreadable_in_a_row_ < kMaxUnreadableInARow) continue;
    next_ = frames_.size();
    return absl::Status(
        images.status().code(),
        absl::StrCat(kMaxUnreadableInARow, " frames in a row can't be read, the last because of ",
                     left_out_.last));
  }
  return std::nullopt;
}

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
    case SourceLayout::kSim:
      return OpenSimulation(spec.simulation);
  }
  return absl::InvalidArgumentError("unknown source layout");
}

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
  absl::StatusOr<std::unique_ptr<FrameReader>> reader = OpenLayout(spec);
  if (reader.ok() || spec.layout == SourceLayout::kSim) return reader;
  return WithLayoutHint(reader.status(), spec);
}

absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(const SourceSpec& spec) {
  ASSIGN_OR_RETURN(std::unique_ptr<FrameReader> reader, OpenReader(spec));
  return PlayReader(std::move(reader), spec);
}

absl::StatusOr<std::unique_ptr<ImageSource>> PlayReader(std::unique_ptr<FrameReader> reader,
                                                        const SourceSpec& spec) {
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
