#include "client_agent/source/listed_reader.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/lists/imu_list.h"
#include "client_agent/source/pictures/grey_depth.h"
#include "client_agent/source/pictures/image_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Number of pictures that are looked at for how many bits a source uses.
constexpr size_t kGreySamples = 8;

class ListedReader : public FrameReader {
 public:
  ListedReader(ListedSequence sequence, int white)
      : calibration_(std::move(sequence.calibration)),
        depth_(std::move(sequence.depth)),
        frames_(std::move(sequence.frames)),
        imu_(std::move(sequence.imu_samples)),
        description_(std::move(sequence.description)),
        kind_(KindOf(calibration_)),
        white_(white) {}

  const SensorCalibration& calibration() const override { return calibration_; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return frames_.size(); }
  int64_t timestamp_ns(size_t frame) const override { return frames_[frame].timestamp_ns; }
  int drive(size_t frame) const override { return frames_[frame].drive; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    const ListedFrame& files = frames_[frame];
    SensorImages images;
    images.timestamp_ns = files.timestamp_ns;
    ASSIGN_OR_RETURN(images.grey, ReadGrey(files.first));
    if (kind_ == SensorKind::kStereo) {
      ASSIGN_OR_RETURN(images.right, ReadGrey(files.second));
    } else if (kind_ == SensorKind::kRgbd) {
      ASSIGN_OR_RETURN(images.depth, ReadDepth(files.second));
    }
    return images;
  }
  ImuSamples Imu(int64_t after_ns, int64_t until_ns) const override {
    return ImuBetween(imu_, after_ns, until_ns);
  }

 private:
  absl::StatusOr<cv::Mat> ReadGrey(const std::string& path) const {
    ASSIGN_OR_RETURN(const cv::Mat image, ReadGreyImage(path));
    RETURN_IF_ERROR(CheckSize(path, image));
    return ScaleGreyTo8(image, white_);
  }
  absl::StatusOr<cv::Mat> ReadDepth(const std::string& path) const {
    ASSIGN_OR_RETURN(const cv::Mat recorded, ReadDepthImage(path));
    absl::StatusOr<cv::Mat> depth = depth_.Prepare(recorded);
    if (!depth.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": ", depth.status().message()));
    }
    RETURN_IF_ERROR(CheckSize(path, *depth));
    return depth;
  }
  absl::Status CheckSize(const std::string& path, const cv::Mat& image) const {
    const Intrinsics& expected = description_.intrinsics;
    if (image.cols == expected.width_px && image.rows == expected.height_px) {
      return absl::OkStatus();
    }
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", image.cols, "x", image.rows,
                                                   " pixels, the calibration is of ",
                                                   expected.width_px, "x", expected.height_px));
  }

  const SensorCalibration calibration_;
  const DepthPreparation depth_;
  const std::vector<ListedFrame> frames_;
  const ImuSamples imu_;
  const SourceDescription description_;
  const SensorKind kind_;
  const int white_;  // Of grey pictures of 16 bits.
};

// Looks at the pictures of the sample that can be read; what can't be read is told when it is
// played.
GreyDepth LookAtGreyDepth(const std::vector<ListedFrame>& frames, bool is_stereo) {
  std::vector<cv::Mat> sample;
  for (size_t k = 0; k < kGreySamples; ++k) {
    const ListedFrame& frame = frames[k * (frames.size() - 1) / (kGreySamples - 1)];
    auto picture = ReadGreyImage(frame.first);
    if (picture.ok() && picture->type() != CV_16UC1) return {};  // All are of one kind.
    if (picture.ok()) sample.push_back(*std::move(picture));
    if (!is_stereo) continue;
    picture = ReadGreyImage(frame.second);
    if (picture.ok()) sample.push_back(*std::move(picture));
  }
  return DecideGreyDepth(sample);
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> MakeListedReader(ListedSequence sequence) {
  SourceDescription& description = sequence.description;
  RETURN_IF_ERROR(TellMissing(sequence.frames, description));
  std::vector<int64_t> times_ns;
  for (const ListedFrame& frame : sequence.frames) times_ns.push_back(frame.timestamp_ns);
  ASSIGN_OR_RETURN(description.times,
                   MeasureTimes(sequence.times_file, times_ns, description.remarks.findings));
  DescribeCamera(sequence.calibration, description);
  description.frames = sequence.frames.size();
  if (description.times_from.empty()) description.times_from = sequence.times_file;
  GreyDepth grey =
      LookAtGreyDepth(sequence.frames, KindOf(sequence.calibration) == SensorKind::kStereo);
  description.remarks.Add(std::move(grey.findings));
  return std::make_unique<ListedReader>(std::move(sequence), grey.White());
}

absl::Status TellMissing(const std::vector<ListedFrame>& frames, SourceDescription& description) {
  size_t missing = 0;
  std::string first_missing;
  for (const ListedFrame& frame : frames) {
    for (const std::string& path : {frame.first, frame.second}) {
      if (path.empty()) continue;
      std::error_code ignored;
      if (std::filesystem::exists(path, ignored)) continue;
      if (missing++ == 0) first_missing = path;
      break;
    }
  }
  if (missing == 0) return absl::OkStatus();
  const std::string text =
      absl::StrCat("of ", missing, " of ", frames.size(),
                   " frames a picture is not there, the first is ", first_missing);
  if (2 * missing > frames.size()) return absl::NotFoundError(text);
  description.remarks.left_out.push_back(text);
  description.remarks.findings.push_back({FindingLevel::kWarning, "pictures-missing",
                                          absl::StrCat(text, ": these frames are left out")});
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
