#include "services/programs/recording/recording.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/lists/imu_list.h"
#include "client_agent/source/pictures/image_file.h"
#include "services/programs/recording/recording_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::ReadDepthImage;
using client_agent::ReadGreyImage;
using client_agent::TrackingState;

namespace {

absl::StatusOr<std::string> ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return absl::NotFoundError(absl::StrCat(
        path, ": can't be read; client_agent --record writes the folder of a recording"));
  }
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

absl::Status AtLine(const std::string& path, size_t line, absl::string_view what) {
  return absl::DataLossError(absl::StrCat(path, ":", line, ": ", what));
}

// Returns what is wrong with the order of the lines; empty where it is right.
absl::string_view Add(const RecordedLine& line, std::vector<RecordedFrame>& frames) {
  if (const auto* const frame = std::get_if<FrameLine>(&line)) {
    if (frame->frame != frames.size()) return "frames are missing before it";
    frames.push_back({.line = *frame});
    return "";
  }
  if (const auto* const orders = std::get_if<OrdersLine>(&line)) {
    const bool fits =
        !frames.empty() && orders->frame + 1 == frames.size() && !frames.back().result.has_value();
    if (!fits) return "is not of the frame before it";
    frames.back().orders = *orders;
    return "";
  }
  const auto& result = std::get<ResultLine>(line);
  if (frames.empty() || result.frame + 1 != frames.size()) return "is not of the frame before it";
  frames.back().result = result.result;
  frames.back().dropped = result.dropped;
  return "";
}

absl::Status ReadLines(Recording& recording) {
  const std::string path = LinesPath(recording.folder);
  ASSIGN_OR_RETURN(const std::string text, ReadText(path));
  size_t number = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = text.find('\n', begin);
    ++number;
    if (end == std::string::npos) {
      recording.notes.push_back(absl::StrCat(path, ":", number, ": cut short, left out"));
      return absl::OkStatus();
    }
    const auto line = ParseLine(absl::string_view(text).substr(begin, end - begin));
    if (!line.ok()) return AtLine(path, number, line.status().message());
    if (const absl::string_view wrong = Add(*line, recording.frames); !wrong.empty()) {
      return AtLine(path, number, wrong);
    }
    begin = end + 1;
  }
  return absl::OkStatus();
}

absl::Status CheckPicture(const std::string& path, const cv::Mat& picture, uint32_t recorded) {
  const uint32_t found = PictureChecksum(picture);
  if (found == recorded) return absl::OkStatus();
  return absl::DataLossError(absl::StrFormat(
      "%s: holds another picture than was recorded: its pixels' checksum is %08x, the recording "
      "says %08x. Was the file replaced, or saved anew with a loss? Take the recording as it was",
      path, found, recorded));
}

absl::Status ReadMask(const std::string& folder, RecordingHead& head) {
  ASSIGN_OR_RETURN(PictureMask mask, ReadGreyImage(MaskPath(folder)));
  if (head.mask_checksum.has_value()) {
    RETURN_IF_ERROR(CheckPicture(MaskPath(folder), mask, *head.mask_checksum));
  }
  std::visit([&](auto& kind) { kind.mask = std::move(mask); }, head.calibration);
  return absl::OkStatus();
}

// Reads the IMU's list, whose samples frames take in its order.
absl::Status ReadImu(Recording& recording) {
  size_t samples = 0;
  for (RecordedFrame& frame : recording.frames) {
    frame.first_sample = samples;
    samples += frame.line.imu_samples;
  }
  if (samples == 0) return absl::OkStatus();
  const std::string path = ImuListPath(recording.folder, recording.kind());
  ASSIGN_OR_RETURN(recording.imu, client_agent::ReadImuLines(path));
  if (recording.imu.size() >= samples) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(path, ": holds ", recording.imu.size(),
                                          " samples, frames.jsonl counts ", samples,
                                          ". Take the recording as it was"));
}

// Returns what the lines say, which is less than a finished run's head does.
RecordedCounts CountLines(const std::vector<RecordedFrame>& frames) {
  RecordedCounts counts;
  counts.frames = frames.size();
  for (const RecordedFrame& frame : frames) {
    if (frame.line.pictures.empty()) ++counts.left_out;
    counts.dropped = std::max(counts.dropped, frame.dropped);
    if (frame.result.has_value() && frame.result->state == TrackingState::kTracking) {
      ++counts.tracked;
    }
  }
  return counts;
}

}  // namespace

absl::StatusOr<Recording> ReadRecording(const std::string& folder) {
  Recording recording;
  recording.folder = folder;
  ASSIGN_OR_RETURN(const std::string text, ReadText(HeadPath(folder)));
  absl::StatusOr<RecordingHead> head = ParseHead(text);
  if (!head.ok()) {
    return absl::DataLossError(absl::StrCat(HeadPath(folder), ": ", head.status().message()));
  }
  recording.head = *std::move(head);
  if (recording.head.has_mask) RETURN_IF_ERROR(ReadMask(folder, recording.head));
  RETURN_IF_ERROR(ReadLines(recording));
  RETURN_IF_ERROR(ReadImu(recording));
  if (!recording.head.finished) {
    recording.head.counts = CountLines(recording.frames);
    recording.notes.emplace_back(
        "the robot's program ended without a word, or is still at it: frames are counted up to the "
        "last one that the recording has");
  }
  if (!recording.head.ended.empty()) {
    recording.notes.push_back("the recording ended before the run: " + recording.head.ended);
  }
  return recording;
}

ImuSamples ImuOf(const Recording& recording, const RecordedFrame& frame) {
  const auto first = recording.imu.begin() + static_cast<std::ptrdiff_t>(frame.first_sample);
  return {first, first + static_cast<std::ptrdiff_t>(frame.line.imu_samples)};
}

absl::StatusOr<PictureMask> ReadOrderedMask(const Recording& recording, const OrdersLine& orders) {
  if (!orders.has_mask.value_or(false)) return PictureMask();
  const std::string path = MaskPath(recording.folder, orders.frame);
  ASSIGN_OR_RETURN(PictureMask mask, ReadGreyImage(path));
  if (orders.mask_checksum.has_value()) {
    RETURN_IF_ERROR(CheckPicture(path, mask, *orders.mask_checksum));
  }
  return mask;
}

absl::StatusOr<SensorImages> ReadPictures(const Recording& recording, const FrameLine& frame) {
  const std::vector<std::string> paths =
      PicturePaths(recording.folder, recording.kind(), frame.pictures);
  SensorImages images;
  images.timestamp_ns = frame.timestamp_ns;
  ASSIGN_OR_RETURN(images.grey, ReadGreyImage(paths[0]));
  if (recording.kind() == SensorKind::kStereo) {
    ASSIGN_OR_RETURN(images.right, ReadGreyImage(paths[1]));
  } else if (recording.kind() == SensorKind::kRgbd) {
    ASSIGN_OR_RETURN(images.depth, ReadDepthImage(paths[1]));
  }
  if (frame.checksums.empty()) return images;
  if (frame.checksums.size() != paths.size()) {
    return absl::DataLossError(absl::StrCat(LinesPath(recording.folder), ": frame ", frame.frame,
                                            " has ", frame.checksums.size(),
                                            " checksums, must have ", paths.size()));
  }
  RETURN_IF_ERROR(CheckPicture(paths[0], images.grey, frame.checksums[0]));
  if (recording.kind() == SensorKind::kMonocular) return images;
  const bool is_stereo = recording.kind() == SensorKind::kStereo;
  RETURN_IF_ERROR(
      CheckPicture(paths[1], is_stereo ? images.right : images.depth, frame.checksums[1]));
  return images;
}

}  // namespace corbslam::services
