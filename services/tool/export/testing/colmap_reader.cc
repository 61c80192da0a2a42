#include "services/tool/export/testing/colmap_reader.h"

#include <algorithm>
#include <fstream>
#include <limits>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"

namespace corbslam::testing {
namespace {

using Fields = std::vector<std::string>;

// Returns all lines but comments; empty ones count (an image may have no keypoints).
absl::StatusOr<std::vector<Fields>> ReadFields(const std::string& path) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat("can't read ", path));
  std::vector<Fields> lines;
  for (std::string line; std::getline(file, line);) {
    if (!absl::StartsWith(line, "#")) lines.push_back(absl::StrSplit(line, ' ', absl::SkipEmpty()));
  }
  return lines;
}

double Number(const std::string& text) {
  double number = std::numeric_limits<double>::quiet_NaN();
  return absl::SimpleAtod(text, &number) ? number : std::numeric_limits<double>::quiet_NaN();
}

int64_t ToInteger(const std::string& text) {
  int64_t number = -2;
  return absl::SimpleAtoi(text, &number) ? number : -2;
}

absl::Status Bad(const std::string& what) { return absl::InvalidArgumentError(what); }

absl::Status ReadCameras(const std::string& path, ColmapModel& model) {
  ASSIGN_OR_RETURN(const std::vector<Fields> lines, ReadFields(path));
  const std::map<std::string, size_t> distortions = {
      {"PINHOLE", 0}, {"OPENCV", 4}, {"FULL_OPENCV", 8}};
  for (const Fields& f : lines) {
    const auto distortion = distortions.find(f.size() > 1 ? f[1] : "");
    if (distortion == distortions.end() || f.size() != 8 + distortion->second) {
      return Bad("a camera's line");
    }
    ColmapCamera& camera = model.cameras[ToInteger(f[0])];
    camera = {static_cast<int>(ToInteger(f[2])),
              static_cast<int>(ToInteger(f[3])),
              Number(f[4]),
              Number(f[5]),
              Number(f[6]),
              Number(f[7]),
              {}};
    for (size_t i = 8; i < f.size(); ++i) camera.distortion.push_back(Number(f[i]));
  }
  return absl::OkStatus();
}

// Projects as COLMAP's documentation of its camera models says.
Eigen::Vector2d ProjectAsColmap(const ColmapCamera& camera, const Eigen::Vector3d& x) {
  std::vector<double> k = camera.distortion;
  k.resize(8);
  const double u = x.x() / x.z();
  const double v = x.y() / x.z();
  const double r2 = u * u + v * v;
  const double radial =
      (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
  const double u_bent = u * radial + 2 * k[2] * u * v + k[3] * (r2 + 2 * u * u);
  const double v_bent = v * radial + 2 * k[3] * u * v + k[2] * (r2 + 2 * v * v);
  return {camera.fx_px * u_bent + camera.cx_px, camera.fy_px * v_bent + camera.cy_px};
}

absl::Status ReadImages(const std::string& path, ColmapModel& model) {
  ASSIGN_OR_RETURN(const std::vector<Fields> lines, ReadFields(path));
  if (lines.size() % 2 != 0) return Bad("an odd number of lines of images");
  for (size_t i = 0; i < lines.size(); i += 2) {
    const Fields& f = lines[i];
    const Fields& keypoints = lines[i + 1];
    if (f.size() != 10 || keypoints.size() % 3 != 0) return Bad("an image's lines");
    ColmapImage& image = model.images[ToInteger(f[0])];
    image.camera_from_world = {
        Eigen::Quaterniond(Number(f[1]), Number(f[2]), Number(f[3]), Number(f[4])),
        {Number(f[5]), Number(f[6]), Number(f[7])}};
    image.camera = ToInteger(f[8]);
    image.name = f[9];
    if (!model.cameras.contains(image.camera)) return Bad("an image's camera");
    for (size_t k = 0; k < keypoints.size(); k += 3) {
      image.keypoints.push_back(
          {{Number(keypoints[k]), Number(keypoints[k + 1])}, ToInteger(keypoints[k + 2])});
    }
  }
  return absl::OkStatus();
}

absl::Status ReadPoints(const std::string& path, ColmapModel& model) {
  ASSIGN_OR_RETURN(const std::vector<Fields> lines, ReadFields(path));
  for (const Fields& f : lines) {
    if (f.size() < 10 || f.size() % 2 != 0) return Bad("a point's line");
    ColmapPoint& point = model.points[ToInteger(f[0])];
    point.position = {Number(f[1]), Number(f[2]), Number(f[3])};
    point.rgb = Eigen::Vector3d(Number(f[4]), Number(f[5]), Number(f[6])).cast<int>();
    point.error_px = Number(f[7]);
    for (size_t k = 8; k < f.size(); k += 2) {
      point.track.emplace_back(ToInteger(f[k]), static_cast<size_t>(ToInteger(f[k + 1])));
    }
  }
  return absl::OkStatus();
}

// Checks that tracks and keypoints say the same.
absl::Status CheckTracks(const ColmapModel& model) {
  size_t sights = 0;
  for (const auto& [id, point] : model.points) {
    for (const auto& [image, keypoint] : point.track) {
      const auto it = model.images.find(image);
      if (it == model.images.end() || keypoint >= it->second.keypoints.size() ||
          it->second.keypoints[keypoint].second != id) {
        return Bad(absl::StrCat("point ", id, ": its track names image ", image, ", keypoint ",
                                keypoint, ", which doesn't see it"));
      }
      ++sights;
    }
  }
  for (const auto& [id, image] : model.images) {
    for (const auto& [pixel, point] : image.keypoints) sights -= point == -1 ? 0 : 1;
  }
  return sights == 0 ? absl::OkStatus() : Bad("keypoints see points whose tracks lack them");
}

}  // namespace

absl::StatusOr<ColmapModel> ReadColmapModel(const std::string& folder) {
  ColmapModel model;
  RETURN_IF_ERROR(ReadCameras(folder + "/cameras.txt", model));
  RETURN_IF_ERROR(ReadImages(folder + "/images.txt", model));
  RETURN_IF_ERROR(ReadPoints(folder + "/points3D.txt", model));
  RETURN_IF_ERROR(CheckTracks(model));
  return model;
}

std::vector<double> ReprojectionErrors_px(const ColmapModel& model) {
  std::vector<double> errors_px;
  for (const auto& [id, point] : model.points) {
    for (const auto& [number, keypoint] : point.track) {
      const ColmapImage& image = model.images.at(number);
      const ColmapCamera& camera = model.cameras.at(image.camera);
      const Eigen::Vector3d x = image.camera_from_world * point.position;
      const Eigen::Vector2d pixel = ProjectAsColmap(camera, x);
      errors_px.push_back(x.z() > 0 ? (pixel - image.keypoints[keypoint].first).norm()
                                    : std::numeric_limits<double>::infinity());
    }
  }
  std::sort(errors_px.begin(), errors_px.end());
  return errors_px;
}

}  // namespace corbslam::testing
