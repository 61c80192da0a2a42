// A mission's map as COLMAP's sparse model in text (cameras.txt, images.txt, points3D.txt): every
// keyframe an image, every landmark a point, every observation a part of its track.
//
// COLMAP's conventions: poses are camera_from_world with w first; the first pixel's centre is at
// (0.5, 0.5), ours at (0, 0), so that principal points and keypoints move by half a pixel.
#ifndef CORBSLAM_SERVICES_MISSION_EXPORT_COLMAP_MODEL_H_
#define CORBSLAM_SERVICES_MISSION_EXPORT_COLMAP_MODEL_H_

#include <cstddef>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/mission_state.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam {

struct ColmapCounts {
  size_t cameras = 0;
  size_t images = 0;
  size_t points = 0;
  size_t observations = 0;
};

// What lies in the mission's global frame, as fusion holds it: landmarks are one point, culled
// keyframes and rejected observations are left out. NOT_FOUND: there is no keyframe.
absl::StatusOr<Map> GlobalMapOf(const map_store::MissionState& state);

// Writes the three files into a folder, which is made. An image is called ROBOT/NANOSECONDS.png
// after its time; a point has the colour of the robot that made it (robot_colours.h). Points that
// nobody sees are left out. `robots` names each local map's. UNAVAILABLE names the path.
absl::StatusOr<ColmapCounts> WriteColmapModel(const Map& map,
                                              const std::map<LocalMapId, std::string>& robots,
                                              const std::string& folder);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_MISSION_EXPORT_COLMAP_MODEL_H_
