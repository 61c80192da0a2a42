// Asks a running map store where pictures were taken.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_PICTURE_SEARCH_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_PICTURE_SEARCH_H_

#include <grpcpp/channel.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/localize.pb.h"
#include "slam/camera/lens.h"

namespace corbslam::services {

struct PictureSearch {
  std::string mission;
  std::vector<std::string> pictures;  // Paths.
  RawCamera camera;                   // Took all of them.
  // The size of picture that its numbers are for, and the file that says so. 0: nobody said it.
  int width_px = 0;
  int height_px = 0;
  std::string calibration;
  std::optional<Eigen::Vector3d> near_m;  // In the global frame.
  double radius_m = 0;
  bool all_islands = false;
};

struct FoundPicture {
  std::string path;
  double seconds = 0;  // From the question to the answer.
  // How the camera's centre lies in the picture, where that is odd; else empty.
  std::string odd_centre;
  v1::LocalizeResponse answer;
};

// Asks about one picture after the other. NOT_FOUND or INVALID_ARGUMENT name a picture's file, also
// where it is of another size than the calibration, and then none is asked about; other errors are
// the store's.
absl::StatusOr<std::vector<FoundPicture>> FindPictures(
    const std::shared_ptr<grpc::Channel>& channel, const PictureSearch& search);

// Reads "fx fy cx cy", in pixels, separated by blanks or commas.
absl::StatusOr<RawCamera> ParseCamera(const std::string& text);
// Reads "x y z", metres.
absl::StatusOr<Eigen::Vector3d> ParsePlace(const std::string& text);

// Returns a line for people: where the camera was and looked, or why nobody knows.
std::string DescribeFound(const FoundPicture& found);
// position_m and forward are those of the camera in the island's frame.
nlohmann::json ToJson(const FoundPicture& found);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_PICTURE_SEARCH_H_
