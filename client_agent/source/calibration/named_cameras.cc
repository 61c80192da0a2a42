#include "client_agent/source/calibration/named_cameras.h"

#include <algorithm>
#include <iterator>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"

namespace corbslam::client_agent {
namespace {

constexpr NamedCamera kCameras[] = {
    {"freiburg1",
     517.306408,
     516.469215,
     318.643040,
     255.313989,
     {0.262383, -0.953104, -0.005358, 0.002628, 1.163314},
     5000},
    {"freiburg2",
     520.908620,
     521.007327,
     325.141442,
     249.701764,
     {0.231222, -0.784899, -0.003257, -0.000105, 0.917205},
     5000},
    {"freiburg3", 535.4, 539.2, 320.1, 247.6, {}, 5000},
    // The published fy is -480: its y axis points up. Rows of pictures count downwards.
    {"icl-nuim", 481.20, 480.00, 319.50, 239.50, {}, 5000},
    {"7-scenes", 585, 585, 320, 240, {}, 1000}};

// Names of recordings in the benchmark's list, without the "rgbd_dataset_freiburg1_" and so on
// before them.
constexpr absl::string_view kFreiburg1[] = {"360",  "desk", "desk2", "floor", "plant",
                                            "room", "rpy",  "teddy", "xyz"};
constexpr absl::string_view kFreiburg2[] = {"360_hemisphere",
                                            "360_kidnap",
                                            "coke",
                                            "desk",
                                            "desk_with_person",
                                            "dishes",
                                            "flowerbouquet",
                                            "flowerbouquet_brownbackground",
                                            "large_no_loop",
                                            "large_with_loop",
                                            "metallic_sphere",
                                            "metallic_sphere2",
                                            "pioneer_360",
                                            "pioneer_slam",
                                            "pioneer_slam2",
                                            "pioneer_slam3",
                                            "rpy",
                                            "xyz"};
constexpr absl::string_view kFreiburg3[] = {"cabinet",
                                            "large_cabinet",
                                            "long_office_household",
                                            "nostructure_notexture_far",
                                            "nostructure_notexture_near_withloop",
                                            "nostructure_texture_far",
                                            "nostructure_texture_near_withloop",
                                            "sitting_halfsphere",
                                            "sitting_rpy",
                                            "sitting_static",
                                            "sitting_xyz",
                                            "structure_notexture_far",
                                            "structure_notexture_near",
                                            "structure_texture_far",
                                            "structure_texture_near",
                                            "teddy",
                                            "walking_halfsphere",
                                            "walking_rpy",
                                            "walking_static",
                                            "walking_xyz"};

template <size_t N>
bool Has(const absl::string_view (&names)[N], absl::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

}  // namespace

const NamedCamera* FindNamedCamera(absl::string_view name) {
  const auto* found = std::find_if(std::begin(kCameras), std::end(kCameras),
                                   [&](const NamedCamera& camera) { return camera.name == name; });
  return found == std::end(kCameras) ? nullptr : found;
}

std::string ListNamedCameras() {
  return absl::StrJoin(kCameras, ", ", [](std::string* text, const NamedCamera& camera) {
    absl::StrAppend(text, camera.name);
  });
}

const NamedCamera* CameraOfTumRecording(absl::string_view recording) {
  absl::string_view rest = absl::StripSuffix(recording, "_validation");
  if (!absl::ConsumePrefix(&rest, "rgbd_dataset_")) return nullptr;
  if (absl::ConsumePrefix(&rest, "freiburg1_")) {
    return Has(kFreiburg1, rest) ? FindNamedCamera("freiburg1") : nullptr;
  }
  if (absl::ConsumePrefix(&rest, "freiburg2_")) {
    return Has(kFreiburg2, rest) ? FindNamedCamera("freiburg2") : nullptr;
  }
  if (absl::ConsumePrefix(&rest, "freiburg3_")) {
    return Has(kFreiburg3, rest) ? FindNamedCamera("freiburg3") : nullptr;
  }
  return nullptr;
}

}  // namespace corbslam::client_agent
