// Calibrations that are known by sight and not read.
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/rig/convert/rig_readers.h"

namespace corbslam::client_agent {
namespace {

struct Foreign {
  std::vector<absl::string_view> signs;  // Texts, all of which such a file has.
  const char* whose;
  const char* advice;
};

constexpr char kByHand[] = "write a rig file by hand (docs/rig.md)";

const std::vector<Foreign>& Known() {
  static const auto& known = *new std::vector<Foreign>{
      {{"[LEFT_CAM_"},
       "a ZED's factory calibration",
       "its SDK and ROS node give rectified pictures: take the fx, fy, cx, cy that they say of "
       "these, and the baseline in metres, not this file's millimetres"},
      {{"Intrinsic of \""},
       "what rs-enumerate-devices -c says of a RealSense",
       "it lists all modes: of the one that runs take Fx, Fy, PPX, PPY, and as baseline what the "
       "extrinsics from \"Infrared 1\" to \"Infrared 2\" say (its infrared pictures are "
       "rectified), "
       "or the depth's units_per_m: 1000 for RGB-D aligned to colour"},
      {{"cameraData", "boardName"},
       "an OAK's (DepthAI's) calibration",
       "its pipeline's StereoDepth node gives rectified pictures, or depth that is aligned: take "
       "the "
       "intrinsics of these by getCameraIntrinsics at the size that runs, and the baseline in "
       "metres, not this file's centimetres"},
      {{"cameraData", "stereoRectificationData"},
       "an OAK's (DepthAI's) calibration",
       "its pipeline's StereoDepth node gives rectified pictures, or depth that is aligned: take "
       "the "
       "intrinsics of these by getCameraIntrinsics at the size that runs, and the baseline in "
       "metres, not this file's centimetres"},
      {{"# Camera list with one line of data per camera"},
       "COLMAP's cameras.txt",
       "it says nothing of where two cameras of a rig are: calibrate the pair"},
      {{"MATLAB 5.0 MAT-file"},
       "MATLAB's",
       "export stereoParameters as M1, D1, M2, D2, R, T (OpenCV's names) with cv.FileStorage's "
       "YAML"},
      {{"<calibration>", "<sensor"},
       "Metashape's",
       "it says nothing of where two cameras of a rig are: calibrate the pair"}};
  return known;
}

}  // namespace

std::string DescribeForeignCalibration(absl::string_view text) {
  for (const Foreign& foreign : Known()) {
    bool has_all = true;
    for (const absl::string_view sign : foreign.signs) {
      has_all = has_all && absl::StrContains(text, sign);
    }
    if (has_all) {
      return absl::StrCat("is ", foreign.whose, ", which is not read: ", foreign.advice, "; ",
                          kByHand);
    }
  }
  return "";
}

}  // namespace corbslam::client_agent
