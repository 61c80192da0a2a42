// Writes a mission's map as COLMAP's sparse model in text (cameras.txt, images.txt, points3D.txt):
// every keyframe is an image, every landmark a point, every observation a part of its track.
//
// The model is of the pictures as they were recorded: cameras have their lens distortion, keypoints
// are where the recorded pictures have them, poses are of the recorded (left) camera. Where a robot
// never said what recorded its pictures, or the rectified camera is wanted, the model is of the
// undistorted pictures that keyframes are of.
//
// COLMAP's poses are camera_from_world with w first. It has the first pixel's centre at (0.5, 0.5),
// we have it at (0, 0), so that principal points and keypoints move by half a pixel.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_COLMAP_MODEL_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_COLMAP_MODEL_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/state/mission_state.h"
#include "slam/camera/recorded_camera.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam::services {

struct ColmapCounts {
  size_t cameras = 0;
  size_t images = 0;
  size_t points = 0;
  size_t observations = 0;
};

// Returns what lies in the mission's global frame, as fusion holds it: each landmark is one point,
// culled keyframes and rejected observations are left out. NOT_FOUND if there is no keyframe.
absl::StatusOr<Map> GlobalMapOf(const map_store::MissionState& state);

// Holds what the model needs beside the map.
struct ColmapSource {
  std::map<LocalMapId, std::string> robots;
  // N of the local map that `mission show` calls ROBOT/N.
  std::map<LocalMapId, size_t> numbers;
  // The key is a local map and a camera index; cameras that are not here are not known.
  std::map<std::pair<LocalMapId, uint32_t>, RecordedCamera> recorded;
  // kRecordedCamera or kRectifiedCamera.
  PosesOf poses_of = PosesOf::kRecordedCamera;
};

// Returns the source of a mission: sessions that have become parts of others are told like these.
ColmapSource ColmapSourceOf(const map_store::MissionState& state, PosesOf poses_of);

// Writes the three files into a folder, which is made. An image is called ROBOT/NANOSECONDS.png
// after its time, or ROBOT+4/NANOSECONDS.png where an earlier local map than ROBOT/4 has a picture
// of that time (ROBOT+4b/... where ROBOT/4 itself has another one, too); a point has the colour of
// the robot that made it (robot_colours.h). Points that nobody sees are left out. UNAVAILABLE names
// the path; INVALID_ARGUMENT a lens for which COLMAP has no model.
absl::StatusOr<ColmapCounts> WriteColmapModel(const Map& map, const ColmapSource& source,
                                              const std::string& folder);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_COLMAP_MODEL_H_
