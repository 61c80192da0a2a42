// Feeds the files of recorded sequences. The first byte says whose; the others are its files.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <variant>

#include "client_agent/source/frame_reader.h"
#include "slam/camera/rectification.h"
#include "slam/evaluation/trajectory_file.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using client_agent::FrameReader;
using client_agent::OpenEuroc;
using client_agent::OpenKitti;
using client_agent::OpenTum;
using client_agent::SourceSpec;

namespace {

// Writes a small picture at each name that the readers open first.
void WritePictures() {
  static const bool done = [] {
    const cv::Mat grey = cv::Mat::zeros(64, 64, CV_8UC1);
    const cv::Mat depth = cv::Mat::zeros(64, 64, CV_16UC1);
    for (const char* name :
         {"kitti/image_0/000000.png", "kitti/image_1/000000.png", "tum/rgb/a.png",
          "euroc/mav0/cam0/data/1.png", "euroc/mav0/cam1/data/1.png"}) {
      cv::imwrite(WriteFuzzFile(name, ""), grey);
    }
    cv::imwrite(WriteFuzzFile("tum/depth/a.png", ""), depth);
    return true;
  }();
  (void)done;
}

// Asks of a sequence what playing it asks.
void Play(const absl::StatusOr<std::unique_ptr<FrameReader>>& reader) {
  if (!reader.ok()) return;
  for (size_t i = 0; i < std::min<size_t>(2, (*reader)->frame_count()); ++i) {
    (void)(*reader)->timestamp_ns(i);
    (void)(*reader)->Read(i);
  }
  const auto* stereo = std::get_if<StereoCalibration>(&(*reader)->calibration());
  constexpr int kMaxPixels = 10000;
  if (stereo == nullptr || !stereo->raw.has_value()) return;
  if (stereo->raw->width_px > kMaxPixels / stereo->raw->height_px) return;
  const auto rectifier = StereoRectifier::Make(*stereo->raw);
  if (rectifier.ok() && !Validate(rectifier->camera()).ok()) std::abort();
}

SourceSpec SpecOf(const std::string& name) {
  SourceSpec spec;
  spec.directory = FuzzFolder() + "/" + name;
  return spec;
}

void ReadKitti(absl::string_view input) {
  WriteFuzzFile("kitti/calib.txt", TakeMessage(input));
  WriteFuzzFile("kitti/times.txt", TakeMessage(input));
  Play(OpenKitti(SpecOf("kitti")));
}

void ReadEuroc(absl::string_view input) {
  for (const char* camera : {"cam0", "cam1"}) {
    const std::string folder = std::string("euroc/mav0/") + camera;
    WriteFuzzFile(folder + "/sensor.yaml", TakeMessage(input));
    WriteFuzzFile(folder + "/data.csv", TakeMessage(input));
  }
  Play(OpenEuroc(SpecOf("euroc")));
}

void ReadTum(absl::string_view input) {
  for (const char* name :
       {"associated.txt", "rgb.txt", "depth.txt", "calibration.yaml", "calibration.txt"}) {
    WriteFuzzFile(std::string("tum/") + name, TakeMessage(input));
  }
  Play(OpenTum(SpecOf("tum")));
}

void ReadTrajectories(absl::string_view input) {
  const std::string first = WriteFuzzFile("first.txt", TakeMessage(input));
  const std::string second = WriteFuzzFile("second.txt", TakeMessage(input));
  (void)ReadTumTrajectory(first);
  (void)ReadKittiTrajectory(first, second);
  (void)ReadKittiTrajectory(first);
  (void)ReadEurocTrajectory(first, Rigid3d::Identity());
  (void)ReadTrajectoryFile(first, second);
  (void)ReadTrajectoryFile(first);
  (void)ReadColmapImages(first);
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  if (size == 0) return 0;
  WritePictures();
  const absl::string_view input = AsText(data + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      ReadKitti(input);
      break;
    case 1:
      ReadEuroc(input);
      break;
    case 2:
      ReadTum(input);
      break;
    default:
      ReadTrajectories(input);
  }
  return 0;
}
