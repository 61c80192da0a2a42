// Reads numbers, lists of them and motions from YAML.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_YAML_NUMBERS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_YAML_NUMBERS_H_

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// Returns a list of `least` to `most` finite numbers. A list of lists (a matrix by its rows) is
// read as one list. INVALID_ARGUMENT names file, field and what was wanted.
absl::StatusOr<std::vector<double>> ReadNumbers(const YAML::Node& list, const std::string& path,
                                                absl::string_view field, size_t least, size_t most);

// Returns one finite number. Errors as ReadNumbers.
absl::StatusOr<double> ReadNumber(const YAML::Node& node, const std::string& path,
                                  absl::string_view field);

// Returns a picture's width and height, pixels, whole numbers from 1 to 16,384. Errors as
// ReadNumbers.
struct PictureSize {
  int width_px = 0;
  int height_px = 0;
};
absl::StatusOr<PictureSize> ReadSize(const YAML::Node& list, const std::string& path,
                                     absl::string_view field);

// The same of two numbers that were read.
absl::StatusOr<PictureSize> ToSize(double width_px, double height_px, const std::string& path,
                                   absl::string_view field);

// Returns the motion of a 4x4 matrix, given by rows, whose translation is in metres.
// INVALID_ARGUMENT names file and field where it is no rigid motion, or a camera so far away that
// it is likely to be given in millimetres.
absl::StatusOr<Rigid3d> ToRigid(const std::vector<double>& rows, const std::string& path,
                                absl::string_view field);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_YAML_NUMBERS_H_
