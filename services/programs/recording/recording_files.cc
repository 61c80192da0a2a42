#include "services/programs/recording/recording_files.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/lists/imu_list.h"
#include "client_agent/source/rig/rig_file.h"
#include "services/programs/recording/calibration_json.h"
#include "slam/util/checksum.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::FormatRig;
using client_agent::Rig;

namespace fs = std::filesystem;

namespace {

absl::Status CantWrite(const std::string& path) {
  return absl::UnavailableError(absl::StrCat("can't write ", path, errno != 0 ? ": " : "",
                                             errno != 0 ? strerror(errno) : ""));
}

absl::Status WriteBytes(const std::string& path, const char* bytes, size_t size) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes, static_cast<std::streamsize>(size));
  file.close();
  return file ? absl::OkStatus() : CantWrite(path);
}

// Without parameters OpenCV's encoder takes the fastest compression.
absl::Status WritePng(const std::string& path, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  try {
    if (!cv::imencode(".png", picture, bytes)) {
      return absl::InternalError(absl::StrCat(path, ": the picture can't be encoded"));
    }
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat(path, ": ", error.what()));
  }
  return WriteBytes(path, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

// Returns the pictures in the order of PictureFolders.
std::vector<cv::Mat> PicturesOf(const SensorImages& images, SensorKind kind) {
  if (kind == SensorKind::kMonocular) return {images.grey};
  return {images.grey, kind == SensorKind::kStereo ? images.right : images.depth};
}

absl::Status CheckKind(const SensorImages& images, SensorKind kind) {
  const cv::Mat last = PicturesOf(images, kind).back();
  const int last_type = kind == SensorKind::kRgbd ? CV_16UC1 : CV_8UC1;
  if (images.grey.type() == CV_8UC1 && last.type() == last_type && !images.grey.empty() &&
      !last.empty()) {
    return absl::OkStatus();
  }
  const char* const wanted = kind == SensorKind::kStereo ? ", and a right one"
                             : kind == SensorKind::kRgbd ? ", and depth of 16 bits"
                                                         : "";
  return absl::UnimplementedError(absl::StrCat(
      "a frame of ", cv::typeToString(images.grey.type()), " and ", cv::typeToString(last.type()),
      ": recordings hold grey pictures of 8 bits", wanted));
}

absl::Status CheckFree(const std::string& folder, uint64_t least_free_bytes) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error || space.available >= least_free_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("the disk of ", folder, " has ", space.available >> 20, " MiB left, ",
                   least_free_bytes >> 20, " MiB stay free for others"));
}

// RGB-D is written in TUM's layout, all else in EuRoC's.
std::vector<std::string> PictureFolders(const std::string& folder, SensorKind kind) {
  if (kind == SensorKind::kRgbd) return {folder + "/rgb", folder + "/depth"};
  std::vector<std::string> folders = {folder + "/mav0/cam0/data"};
  if (kind == SensorKind::kStereo) folders.push_back(folder + "/mav0/cam1/data");
  return folders;
}

// Each list's path and its heading.
std::vector<std::pair<std::string, std::string>> ListsOf(const std::string& folder,
                                                         SensorKind kind) {
  if (kind == SensorKind::kRgbd) {
    return {{folder + "/rgb.txt", "# timestamp filename"},
            {folder + "/depth.txt", "# timestamp filename"},
            {folder + "/associated.txt", "# timestamp rgb timestamp depth"}};
  }
  std::vector<std::pair<std::string, std::string>> lists;
  for (const std::string& pictures : PictureFolders(folder, kind)) {
    lists.emplace_back(fs::path(pictures).parent_path().string() + "/data.csv",
                       "#timestamp [ns],filename");
  }
  return lists;
}

std::vector<std::string> ListLines(SensorKind kind, int64_t timestamp_ns, const std::string& name) {
  if (kind != SensorKind::kRgbd) {
    return std::vector<std::string>(kind == SensorKind::kStereo ? 2 : 1,
                                    absl::StrCat(timestamp_ns, ",", name));
  }
  const std::string rgb = absl::StrCat(FormatSeconds(timestamp_ns), " rgb/", name);
  const std::string depth = absl::StrCat(FormatSeconds(timestamp_ns), " depth/", name);
  return {rgb, depth, absl::StrCat(rgb, " ", depth)};
}

const PictureMask& MaskOf(const SensorCalibration& calibration) {
  return std::visit([](const auto& kind) -> const PictureMask& { return kind.mask; }, calibration);
}

const std::optional<ImuCalibration>& ImuOf(const SensorCalibration& calibration) {
  return std::visit(
      [](const auto& kind) -> const auto& { return kind.imu; }, calibration);
}

// Where the body is that T_BS is of: where a calibration says it, else at the IMU.
Rigid3d BodyFromImu(const SensorCalibration& calibration) {
  const std::optional<Rigid3d> body_from_camera = FirstCameraOf(calibration).body_from_raw;
  if (!body_from_camera.has_value()) return {};
  return *body_from_camera * ImuOf(calibration)->imu_from_camera.Inverse();
}

// Returns imu0/sensor.yaml in EuRoC's form.
std::string FormatImuSensor(const SensorCalibration& calibration) {
  const ImuCalibration& imu = *ImuOf(calibration);
  const Rigid3d pose = BodyFromImu(calibration);
  const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) absl::StrAppend(&rows, FormatReal(r(i, k)), ", ");
    absl::StrAppend(&rows, FormatReal(pose.translation(i)), ", ");
  }
  return absl::StrCat("# What a robot recorded; rig.yaml says where the camera sits.\n",
                      "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [", rows,
                      "0, 0, 0, 1]\nrate_hz: ", FormatReal(imu.rate_hz),
                      "\ngyroscope_noise_density: ", FormatReal(imu.noise.gyro),
                      "\ngyroscope_random_walk: ", FormatReal(imu.noise.gyro_walk),
                      "\naccelerometer_noise_density: ", FormatReal(imu.noise.accel),
                      "\naccelerometer_random_walk: ", FormatReal(imu.noise.accel_walk), "\n");
}

absl::Status AppendTo(const std::string& path, std::ofstream& file, const std::string& line) {
  errno = 0;
  file << line << "\n" << std::flush;
  return file ? absl::OkStatus() : CantWrite(path);
}

}  // namespace

std::string HeadPath(const std::string& folder) { return folder + "/recording.json"; }
std::string LinesPath(const std::string& folder) { return folder + "/frames.jsonl"; }
std::string MaskPath(const std::string& folder) { return folder + "/mask.png"; }
std::string MaskPath(const std::string& folder, uint64_t frame) {
  return absl::StrCat(folder, "/masks/", frame, ".png");
}

std::vector<std::string> PicturePaths(const std::string& folder, SensorKind kind,
                                      const std::string& pictures) {
  std::vector<std::string> paths;
  for (const std::string& of_camera : PictureFolders(folder, kind)) {
    paths.push_back(absl::StrCat(of_camera, "/", pictures));
  }
  return paths;
}

std::string ImuListPath(const std::string& folder, SensorKind kind) {
  return absl::StrCat(folder, kind == SensorKind::kRgbd ? "" : "/mav0", "/imu0/data.csv");
}

uint32_t PictureChecksum(const cv::Mat& picture) {
  const int32_t head[] = {picture.rows, picture.cols, picture.type()};
  uint32_t checksum = ExtendCrc32c(0, {reinterpret_cast<const char*>(head), sizeof(head)});
  const size_t row_bytes = static_cast<size_t>(picture.cols) * picture.elemSize();
  for (int row = 0; row < picture.rows; ++row) {
    checksum = ExtendCrc32c(checksum, {picture.ptr<char>(row), row_bytes});
  }
  return checksum;
}

std::string SourceOfRecording(const std::string& folder, SensorKind kind) {
  return absl::StrCat(kind == SensorKind::kRgbd ? "tum:" : "euroc:", folder, "?rig=", folder,
                      "/rig.yaml");
}

absl::Status CheckRecordingFolder(const std::string& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) return absl::OkStatus();
  if (!fs::is_directory(folder, error)) {
    return absl::FailedPreconditionError(folder + ": is no folder");
  }
  if (fs::directory_iterator(folder, error) == fs::directory_iterator() && !error) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      error ? absl::StrCat(folder, ": ", error.message())
            : absl::StrCat(folder, ": holds something already: a recording takes a new folder"));
}

absl::StatusOr<std::unique_ptr<RecordingFiles>> RecordingFiles::Create(
    const std::string& folder, const RecordingHead& head, std::optional<double> rate_hz) {
  RETURN_IF_ERROR(CheckRecordingFolder(folder));
  std::unique_ptr<RecordingFiles> files(new RecordingFiles(folder, KindOf(head.calibration)));
  for (const std::string& pictures : PictureFolders(folder, files->kind_)) {
    RETURN_IF_ERROR(MakeFolder(pictures));
  }
  RETURN_IF_ERROR(files->WriteRig(head, rate_hz));
  RETURN_IF_ERROR(files->MakeLists());
  RETURN_IF_ERROR(files->MakeImuFiles(head.calibration));
  RETURN_IF_ERROR(files->WriteHead(head));
  return files;
}

absl::Status RecordingFiles::MakeLists() {
  std::vector<std::pair<std::string, std::string>> wanted = ListsOf(folder_, kind_);
  wanted.emplace_back(LinesPath(folder_), "");
  for (const auto& [path, heading] : wanted) {
    List& list = lists_.emplace_back(List{path, std::ofstream(path, std::ios::trunc)});
    if (!list.file) return CantWrite(path);
    if (!heading.empty()) RETURN_IF_ERROR(AppendTo(path, list.file, heading));
  }
  return absl::OkStatus();
}

absl::Status RecordingFiles::MakeImuFiles(const SensorCalibration& calibration) {
  if (!ImuOf(calibration).has_value()) return absl::OkStatus();
  const std::string path = ImuListPath(folder_, kind_);
  const std::string of_imu = fs::path(path).parent_path().string();
  RETURN_IF_ERROR(MakeFolder(of_imu));
  const std::string sensor = FormatImuSensor(calibration);
  RETURN_IF_ERROR(WriteBytes(of_imu + "/sensor.yaml", sensor.data(), sensor.size()));
  imu_list_.emplace(List{path, std::ofstream(path, std::ios::trunc)});
  if (!imu_list_->file) return CantWrite(path);
  return AppendTo(path, imu_list_->file, client_agent::kImuHeading);
}

absl::Status RecordingFiles::WriteImu(const ImuSamples& samples) {
  if (!imu_list_.has_value() || samples.empty()) return absl::OkStatus();
  std::vector<std::string> lines;
  for (const ImuSample& sample : samples) lines.push_back(client_agent::FormatImuLine(sample));
  return AppendTo(imu_list_->path, imu_list_->file, absl::StrJoin(lines, "\n"));
}

absl::Status RecordingFiles::WriteRig(const RecordingHead& head, std::optional<double> rate_hz) {
  Rig rig = RigOf(head.calibration);
  rig.rate_hz = rate_hz;
  if (const PictureMask& mask = MaskOf(head.calibration); !mask.empty()) {
    RETURN_IF_ERROR(WritePng(MaskPath(folder_), mask));
    rig.mask_file = "mask.png";
  }
  const std::string text = FormatRig(rig, "what a robot recorded");
  return WriteBytes(folder_ + "/rig.yaml", text.data(), text.size());
}

absl::Status RecordingFiles::WriteHead(RecordingHead head) {
  if (const PictureMask& mask = MaskOf(head.calibration); !mask.empty()) {
    head.mask_checksum = PictureChecksum(mask);
  }
  const std::string path = HeadPath(folder_);
  const std::string text = FormatHead(head);
  RETURN_IF_ERROR(WriteBytes(path + ".new", text.data(), text.size()));
  std::error_code error;
  fs::rename(path + ".new", path, error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("can't write ", path, ": ", error.message()));
}

// Files are called after their time, as in the layouts; after their number too where times fall, as
// they do where a drive begins anew.
std::string RecordingFiles::NameOf(const FrameLine& line) {
  const bool grows = !latest_ns_.has_value() || line.timestamp_ns > *latest_ns_;
  if (grows) latest_ns_ = line.timestamp_ns;
  const std::string time = kind_ == SensorKind::kRgbd ? FormatSeconds(line.timestamp_ns)
                                                      : absl::StrCat(line.timestamp_ns);
  return grows ? absl::StrCat(time, ".png") : absl::StrCat(time, "-", line.frame, ".png");
}

absl::Status RecordingFiles::WriteFrame(const SensorImages& images, uint64_t least_free_bytes,
                                        FrameLine line) {
  RETURN_IF_ERROR(CheckKind(images, kind_));
  RETURN_IF_ERROR(CheckFree(folder_, least_free_bytes));
  line.pictures = NameOf(line);
  const std::vector<cv::Mat> pictures = PicturesOf(images, kind_);
  const std::vector<std::string> paths = PicturePaths(folder_, kind_, line.pictures);
  line.checksums.clear();
  for (size_t i = 0; i < pictures.size(); ++i) {
    line.checksums.push_back(PictureChecksum(pictures[i]));
    RETURN_IF_ERROR(WritePng(paths[i], pictures[i]));
  }
  RETURN_IF_ERROR(AppendToLists(line.timestamp_ns, line.pictures));
  return WriteLine(line);
}

absl::Status RecordingFiles::AppendToLists(int64_t timestamp_ns, const std::string& pictures) {
  const std::vector<std::string> lines = ListLines(kind_, timestamp_ns, pictures);
  for (size_t i = 0; i < lines.size(); ++i) {
    RETURN_IF_ERROR(AppendTo(lists_[i].path, lists_[i].file, lines[i]));
  }
  return absl::OkStatus();
}

absl::Status RecordingFiles::WriteLine(const RecordedLine& line) {
  return AppendTo(lists_.back().path, lists_.back().file, FormatLine(line));
}

absl::Status RecordingFiles::WriteOrders(OrdersLine line, const PictureMask& mask) {
  if (!mask.empty()) {
    line.mask_checksum = PictureChecksum(mask);
    RETURN_IF_ERROR(MakeFolder(folder_ + "/masks"));
    RETURN_IF_ERROR(WritePng(MaskPath(folder_, line.frame), mask));
  }
  return WriteLine(line);
}

}  // namespace corbslam::services
