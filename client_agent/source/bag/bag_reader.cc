#include "client_agent/source/bag/bag_reader.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/bag_frames.h"
#include "client_agent/source/bag/bag_imu.h"
#include "client_agent/source/bag/camera_info_rig.h"
#include "client_agent/source/bag/picture_topic.h"
#include "client_agent/source/bag/rig_choice.h"
#include "client_agent/source/imu_opening.h"
#include "client_agent/source/lists/imu_list.h"
#include "client_agent/source/pictures/grey_depth.h"
#include "client_agent/source/rig/rig_depth.h"
#include "client_agent/source/rig/rig_file.h"
#include "client_agent/source/scaled_reader.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kGreySamples = 8;
constexpr double kStereoWithin_ms = 2;
constexpr double kDepthWithin_ms = 20;

// What makes a reader, as it comes together.
struct BagParts {
  std::shared_ptr<const BagContents> contents;
  RigChoice choice;
  Rig rig;
  SensorCalibration calibration;
  DepthPreparation depth;
  std::vector<BagFrame> frames;
  bool by_recording_time = false;
  ImuSamples imu;  // By the clock of the frames.
  SourceDescription description;
  int white = 256;  // Of grey pictures of 16 bits.
};

class BagReader : public FrameReader {
 public:
  explicit BagReader(BagParts parts) : parts_(std::move(parts)) {}

  const SensorCalibration& calibration() const override { return parts_.calibration; }
  const SourceDescription& description() const override { return parts_.description; }
  size_t frame_count() const override { return parts_.frames.size(); }
  int64_t timestamp_ns(size_t frame) const override { return parts_.frames[frame].timestamp_ns; }
  int drive(size_t frame) const override { return parts_.frames[frame].drive; }
  absl::StatusOr<SensorImages> Read(size_t number) const override {
    const BagFrame& frame = parts_.frames[number];
    SensorImages images;
    images.timestamp_ns = frame.timestamp_ns;
    ASSIGN_OR_RETURN(images.grey, ReadGrey(parts_.choice.first, frame.first, frame.timestamp_ns));
    if (parts_.choice.kind == RigKind::kStereo) {
      ASSIGN_OR_RETURN(images.right,
                       ReadGrey(parts_.choice.second, frame.second, frame.timestamp_ns));
      return images;
    }
    ASSIGN_OR_RETURN(images.depth, ReadDepth(frame));
    return images;
  }
  ImuSamples Imu(int64_t after_ns, int64_t until_ns) const override {
    return ImuBetween(parts_.imu, after_ns, until_ns);
  }

 private:
  absl::StatusOr<cv::Mat> ReadGrey(const PictureTopic& topic, const RecordedPlace& place,
                                   int64_t time_ns) const {
    ASSIGN_OR_RETURN(const cv::Mat grey, ReadBagGrey(*parts_.contents, topic, place, time_ns));
    RETURN_IF_ERROR(CheckSize(topic, time_ns, grey));
    return ScaleGreyTo8(grey, parts_.white);
  }
  absl::StatusOr<cv::Mat> ReadDepth(const BagFrame& frame) const {
    const PictureTopic& topic = parts_.choice.second;
    ASSIGN_OR_RETURN(const cv::Mat recorded,
                     ReadBagDepth(*parts_.contents, topic, frame.second, frame.timestamp_ns));
    absl::StatusOr<cv::Mat> depth = parts_.depth.Prepare(recorded);
    if (!depth.ok()) return Bad(topic, frame.timestamp_ns, depth.status().message());
    RETURN_IF_ERROR(CheckSize(topic, frame.timestamp_ns, *depth));
    return depth;
  }
  absl::Status CheckSize(const PictureTopic& topic, int64_t time_ns, const cv::Mat& image) const {
    const Intrinsics& expected = parts_.description.intrinsics;
    if (image.cols == expected.width_px && image.rows == expected.height_px) {
      return absl::OkStatus();
    }
    return Bad(topic, time_ns,
               absl::StrCat(image.cols, "x", image.rows, " pixels, the calibration is of ",
                            expected.width_px, "x", expected.height_px));
  }
  absl::Status Bad(const PictureTopic& topic, int64_t time_ns, absl::string_view what) const {
    return absl::InvalidArgumentError(absl::StrCat(parts_.contents->recording->path(), ": ",
                                                   topic.name(), ": the picture of ",
                                                   FormatSeconds(time_ns), " s: ", what));
  }

  const BagParts parts_;
};

absl::StatusOr<std::optional<Rig>> ReadGivenRig(const BagOptions& options) {
  if (options.rig_file.empty()) return std::nullopt;
  ASSIGN_OR_RETURN(Rig rig, ReadRigFile(options.rig_file));
  if (rig.kind != RigKind::kMonocular) return rig;
  return absl::InvalidArgumentError(absl::StrCat(
      options.rig_file,
      ": is of one camera alone (kind: monocular), which bags are not played with yet: "
      "give the rig of a pair or an RGB-D camera, and cameras=1 beside it"));
}

// The named CameraInfo of what was chosen.
absl::Status UseNamedInfo(const BagOptions& options, BagParts& parts) {
  RigChoice& choice = parts.choice;
  const bool is_stereo = choice.kind == RigKind::kStereo;
  if (!options.left_info.empty()) {
    RETURN_IF_ERROR(UseCameraInfo(*parts.contents, options.left_info, choice.first));
  }
  const std::string& second = is_stereo ? options.right_info : options.depth_info;
  if (second.empty()) return absl::OkStatus();
  return UseCameraInfo(*parts.contents, second, choice.second);
}

absl::Status TakeRig(const BagOptions& options, std::optional<Rig> given, const TransformTree& tree,
                     BagParts& parts) {
  SourceDescription& description = parts.description;
  if (given.has_value()) {
    parts.rig = *std::move(given);
    description.intrinsics_from = options.rig_file;
    description.depth_units_from = options.rig_file;
  } else {
    ASSIGN_OR_RETURN(CameraInfoRig made,
                     MakeCameraInfoRig(options.path, parts.choice, tree, options));
    parts.rig = std::move(made.rig);
    description.intrinsics_from = std::move(made.from);
    description.depth_units_from = std::move(made.depth_units_from);
    description.remarks.Add(std::move(made.findings));
  }
  ASSIGN_OR_RETURN(SourceFindings findings,
                   JudgeRig(parts.rig, description.intrinsics_from, options.trust_calibration));
  description.remarks.Add(std::move(findings));
  ASSIGN_OR_RETURN(parts.calibration, CalibrationOf(parts.rig));
  if (parts.rig.kind == RigKind::kStereo) return absl::OkStatus();
  ASSIGN_OR_RETURN(parts.depth, DepthPreparation::Make(parts.rig, options.registers));
  description.depth_registration = parts.depth.description();
  return absl::OkStatus();
}

absl::Status ListBagFrames(const BagOptions& options, BagParts& parts) {
  const double usual_ms =
      parts.choice.kind == RigKind::kStereo ? kStereoWithin_ms : kDepthWithin_ms;
  const double within_ms = options.pair_within_ms.value_or(usual_ms);
  const FramePairing pairing{options.path, options.by_recording_time,
                             static_cast<int64_t>(std::llround(1e6 * within_ms)),
                             SecondTimeOffset_ns(parts.rig)};
  SourceDescription& description = parts.description;
  ASSIGN_OR_RETURN(BagFrames made,
                   MakeBagFrames(*parts.choice.first.topic, *parts.choice.second.topic, pairing,
                                 description.remarks));
  parts.frames = std::move(made.frames);
  parts.by_recording_time = made.by_recording_time;
  std::vector<int64_t> times_ns;
  for (const BagFrame& frame : parts.frames) times_ns.push_back(frame.timestamp_ns);
  ASSIGN_OR_RETURN(description.times,
                   MeasureTimes(options.path, times_ns, description.remarks.findings));
  description.frames = parts.frames.size();
  description.times_from = absl::StrCat(
      made.by_recording_time ? "the recorder, of " : "the headers of ", parts.choice.first.name());
  return absl::OkStatus();
}

absl::Status TakeBagImu(const BagOptions& options, const TransformTree& tree, BagParts& parts) {
  SetImu(std::nullopt, parts.calibration);
  const BagImuQuery query{options,
                          tree,
                          parts.rig.imu,
                          parts.choice.first.frame_id,
                          parts.by_recording_time,
                          parts.frames.back().drive > 0};
  SourceRemarks& remarks = parts.description.remarks;
  ASSIGN_OR_RETURN(std::optional<BagImu> imu, FindBagImu(*parts.contents, query, remarks));
  if (!imu.has_value()) return absl::OkStatus();
  ImuExpectation expected;
  expected.from = imu->from;
  expected.first_picture_ns = parts.frames.front().timestamp_ns;
  expected.last_picture_ns = parts.frames.back().timestamp_ns;
  expected.trust = options.trust_calibration;
  parts.imu = std::move(imu->samples);
  return TakeSamples(imu->stated, expected, parts.imu, parts.calibration, parts.description);
}

// Looks at pictures of 16 bits for how many of them the camera uses.
void LookAtGrey(BagParts& parts) {
  std::vector<cv::Mat> sample;
  for (size_t k = 0; k < kGreySamples; ++k) {
    const BagFrame& frame = parts.frames[k * (parts.frames.size() - 1) / (kGreySamples - 1)];
    const auto grey =
        ReadBagGrey(*parts.contents, parts.choice.first, frame.first, frame.timestamp_ns);
    if (grey.ok() && grey->type() != CV_16UC1) return;  // All are of one kind.
    if (grey.ok()) sample.push_back(*grey);
  }
  GreyDepth decided = DecideGreyDepth(sample);
  parts.white = decided.White();
  parts.description.remarks.Add(std::move(decided.findings));
}

void Describe(const BagOptions& options, BagParts& parts) {
  const RigChoice& choice = parts.choice;
  SourceDescription& description = parts.description;
  description.layout = absl::StrCat(
      parts.contents->recording->format(), ", ",
      choice.kind == RigKind::kStereo ? "stereo pair: " : "RGB-D: ", DescribeTopic(choice.first),
      ", ", DescribeTopic(choice.second));
  DescribeCamera(parts.calibration, description);
  for (const std::string& note : parts.contents->recording->notes()) {
    description.remarks.findings.push_back({FindingLevel::kWarning, "bag-not-whole", note});
  }
  const bool is_named = !options.left.empty() && !(options.right.empty() && options.depth.empty());
  if (is_named) return;
  for (const std::string& other : choice.others) {
    description.remarks.left_out.push_back(absl::StrCat("could be played too: ?", other));
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenBagContents(
    std::shared_ptr<const BagContents> contents, const BagOptions& options) {
  BagParts parts;
  parts.contents = std::move(contents);
  ASSIGN_OR_RETURN(std::optional<Rig> given, ReadGivenRig(options));
  const TransformTree tree = ReadFixedTransforms(*parts.contents);
  ASSIGN_OR_RETURN(parts.choice,
                   ChooseRig(options.path, LookAtPictures(*parts.contents), tree, options,
                             given.has_value() ? std::optional(given->kind) : std::nullopt));
  RETURN_IF_ERROR(UseNamedInfo(options, parts));
  RETURN_IF_ERROR(TakeRig(options, std::move(given), tree, parts));
  RETURN_IF_ERROR(ListBagFrames(options, parts));
  RETURN_IF_ERROR(TakeBagImu(options, tree, parts));
  LookAtGrey(parts);
  Describe(options, parts);
  std::unique_ptr<FrameReader> reader = std::make_unique<BagReader>(std::move(parts));
  if (options.scale == 1) return reader;
  return ScaleReader(std::move(reader), options.scale);
}

absl::StatusOr<std::unique_ptr<FrameReader>> OpenBag(const BagOptions& options) {
  ASSIGN_OR_RETURN(std::shared_ptr<const BagContents> contents, ReadBagContents(options.path));
  return OpenBagContents(std::move(contents), options);
}

}  // namespace corbslam::client_agent
