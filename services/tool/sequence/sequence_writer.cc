#include "services/tool/sequence/sequence_writer.h"

#include <atomic>
#include <cstdint>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/rig/rig_file.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/sequence/layout_files.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::FormatRig;
using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::FramesOf;
using client_agent::OpenReader;
using client_agent::ReadPerturbed;
using client_agent::ReadRigFile;
using client_agent::Rig;
using client_agent::SourceLayout;
using client_agent::SourceSpec;

namespace {

// More compression gains little: most of a picture is noise.
constexpr int kPngCompression = 1;

// So much of what was measured before the first picture is written.
constexpr int64_t kImuBefore_ns = 2'000'000'000;

absl::Status WritePicture(const cv::Mat& image, const std::string& path) {
  std::vector<uint8_t> bytes;
  try {
    if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, kPngCompression})) {
      return absl::InternalError(absl::StrCat("cannot encode ", path));
    }
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat(path, ": ", exception.what()));
  }
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  return file ? absl::OkStatus() : absl::UnavailableError(absl::StrCat("cannot write ", path));
}

// Draws and writes the frames of one source by several threads.
class FrameWriter {
 public:
  FrameWriter(const SourceSpec& source, const WriteSequenceOptions& options,
              const FrameReader& reader, const std::vector<size_t>& frames)
      : source_(source), options_(options), reader_(reader), frames_(frames) {}

  absl::Status WriteAll() {
    std::vector<std::thread> threads;
    for (int i = 1; i < options_.threads; ++i) threads.emplace_back([this] { Work(); });
    Work();
    for (std::thread& thread : threads) thread.join();
    absl::MutexLock lock(&mutex_);
    return status_;
  }

 private:
  absl::Status Write(size_t index) const {
    const size_t frame = frames_[index];
    ASSIGN_OR_RETURN(const SensorImages images,
                     ReadPerturbed(reader_, frame, source_.perturbation));
    const FramePaths paths = PathsOfFrame(options_.layout, index, images.timestamp_ns);
    const cv::Mat& second = images.right.empty() ? images.depth : images.right;
    RETURN_IF_ERROR(WritePicture(images.grey, absl::StrCat(options_.folder, "/", paths.first)));
    return WritePicture(second, absl::StrCat(options_.folder, "/", paths.second));
  }

  // Takes frames until none is left or one could not be written.
  void Work() {
    for (size_t index = next_++; index < frames_.size(); index = next_++) {
      const absl::Status status = Write(index);
      absl::MutexLock lock(&mutex_);
      if (status_.ok()) status_ = status;
      if (!status_.ok()) return;
      ++done_;
      if (options_.on_progress != nullptr) options_.on_progress(done_, frames_.size());
    }
  }

  const SourceSpec& source_;
  const WriteSequenceOptions& options_;
  const FrameReader& reader_;
  const std::vector<size_t>& frames_;
  std::atomic<size_t> next_ = 0;
  absl::Mutex mutex_;
  size_t done_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

// Writes the rig beside the pictures: with it they are played.
absl::Status CopyRig(const std::string& from, const std::string& to) {
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(from));
  return WriteLines(absl::StrSplit(FormatRig(rig, "a simulated sequence"), '\n'), to);
}

CameraRig RigOfLayout(SourceLayout layout) {
  if (layout == SourceLayout::kTum) return CameraRig::kRgbd;
  return layout == SourceLayout::kEuroc ? CameraRig::kEuroc : CameraRig::kKitti;
}

}  // namespace

absl::StatusOr<size_t> WriteSequence(const SourceSpec& source,
                                     const WriteSequenceOptions& options) {
  const SimulationSpec* asked_for = FindSimulation(source);
  if (asked_for == nullptr || options.layout == SourceLayout::kRegistered) {
    return absl::InvalidArgumentError(
        absl::StrCat(FormatSourceSpec(source), " is no simulation that can be written"));
  }
  if (source.selection.reverse) {
    return absl::InvalidArgumentError("reverse=1: recordings are written forwards; try turned=1");
  }
  SimulationSpec simulation = *asked_for;
  if (!simulation.rig.has_value() && !simulation.pair.has_value()) {
    simulation.rig = RigOfLayout(options.layout);
  }
  // Several frames are drawn at a time, each by one thread.
  simulation.threads = 1;
  SourceSpec drawn = source;
  SetSimulation(simulation, drawn);
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(drawn));
  const std::vector<size_t> frames = FramesOf(drawn, reader->frame_count());
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(drawn));
  Trajectory written;
  for (const size_t frame : frames) written.push_back(truth->trajectory[frame]);
  const std::optional<ImuCalibration> imu =
      std::visit([](const auto& sensor) { return sensor.imu; }, reader->calibration());
  if (imu.has_value() && options.layout != SourceLayout::kEuroc) {
    return absl::InvalidArgumentError(
        "imu: only the layout euroc has a file for what an IMU measured; write that, or imu=0");
  }
  RETURN_IF_ERROR(MakeLayoutFolders(options.layout, options.folder));
  RETURN_IF_ERROR(WriteLayoutFiles(options.layout, options.folder, reader->calibration(), written));
  if (imu.has_value()) {
    const ImuSamples samples =
        reader->Imu(written.front().timestamp_ns - kImuBefore_ns, written.back().timestamp_ns);
    RETURN_IF_ERROR(WriteEurocImu(options.folder, *imu, samples));
  }
  if (simulation.pair.has_value()) {
    RETURN_IF_ERROR(CopyRig(simulation.pair->file, options.folder + "/rig.yaml"));
  }
  RETURN_IF_ERROR(FrameWriter(drawn, options, *reader, frames).WriteAll());
  return frames.size();
}

}  // namespace corbslam::services
