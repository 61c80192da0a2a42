#include "client_agent/source/kitti_folders.h"

#include <filesystem>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;

bool IsFolder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

// Cameras 0 and 1 are grey, 2 and 3 are colour.
KittiFolders Odometry(const std::string& directory, bool colour) {
  const int left = colour ? 2 : 0;
  return {absl::StrCat("KITTI odometry, ", colour ? "colour" : "grey"),
          absl::StrCat(directory, "/image_", left),
          absl::StrCat(directory, "/image_", left + 1),
          directory + "/calib.txt",
          absl::StrCat("P", left),
          absl::StrCat("P", left + 1),
          directory + "/times.txt"};
}

KittiFolders Raw(const std::string& directory, bool colour) {
  const int left = colour ? 2 : 0;
  std::string calibration = directory + "/calib_cam_to_cam.txt";
  std::error_code ignored;
  if (!fs::exists(calibration, ignored)) calibration = directory + "/../calib_cam_to_cam.txt";
  return {absl::StrCat("KITTI raw, ", colour ? "colour" : "grey"),
          absl::StrCat(directory, "/image_0", left, "/data"),
          absl::StrCat(directory, "/image_0", left + 1, "/data"),
          calibration,
          absl::StrCat("P_rect_0", left),
          absl::StrCat("P_rect_0", left + 1),
          absl::StrCat(directory, "/image_0", left, "/timestamps.txt")};
}

}  // namespace

absl::StatusOr<KittiFolders> FindKittiFolders(const SourceSpec& spec, bool one_camera) {
  for (const bool colour : {false, true}) {
    if (!spec.opening.images.empty() && (spec.opening.images == "colour") != colour) continue;
    for (const KittiFolders& folders :
         {Odometry(spec.directory, colour), Raw(spec.directory, colour)}) {
      if (IsFolder(folders.left) && (one_camera || IsFolder(folders.right))) return folders;
    }
  }
  return absl::NotFoundError(
      absl::StrCat(spec.directory, one_camera ? ": no pictures" : ": no pictures of a stereo pair",
                   ": KITTI has image_0 and image_1 (grey) or image_2 and image_3 "
                   "(colour), KITTI raw has image_00/data and image_01/data"));
}

}  // namespace corbslam::client_agent
