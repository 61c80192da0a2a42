// Draws what people may say of the camera that took a picture, and what becomes of pictures before
// somebody asks where they were taken: all of it wrong.
#ifndef CORBSLAM_TESTS_ACCURACY_SAID_CAMERAS_H_
#define CORBSLAM_TESTS_ACCURACY_SAID_CAMERAS_H_

#include <opencv2/core/mat.hpp>
#include <random>
#include <string>
#include <vector>

#include "slam/camera/lens.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::tests {

// A picture, what is said of its camera, and how that camera stood to the one that took it.
struct SaidPicture {
  cv::Mat grey;
  RawCamera camera;
  Rigid3d said_from_true;  // A rotation: of a picture that was turned.
  // No pose at all is right: of a mirrored picture.
  bool has_no_place = false;
};

// Returns what is wrong of the n-th kind, in words.
const std::vector<std::string>& WrongKinds();

// Changes the true camera, or the picture, in the way of that kind.
SaidPicture SayWrongly(size_t kind, const cv::Mat& grey, const RawCamera& truth,
                       std::mt19937_64& random);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_ACCURACY_SAID_CAMERAS_H_
