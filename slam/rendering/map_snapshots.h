// A mission's past as pictures, like figure 4 of the CORB-SLAM paper: the maps of robots apart,
// then fused, each state drawn in the same view.
#ifndef CORBSLAM_SLAM_RENDERING_MAP_SNAPSHOTS_H_
#define CORBSLAM_SLAM_RENDERING_MAP_SNAPSHOTS_H_

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/rendering/map_cell.h"
#include "slam/rendering/map_picture.h"

namespace corbslam {

// All of a mission at one moment.
struct MapSnapshot {
  struct Island {
    uint64_t id = 0;         // Names the island, and so its frame, from one snapshot to the next.
    bool is_global = false;  // It lies in the mission's global frame.
    MapPicture map;          // Its title stands above it.
  };
  std::string title;
  std::vector<Island> islands;
};

// Where the islands of all snapshots are drawn. It is shown all of them first; each island is then
// looked at as where it was largest, so that what is fixed stands still. The global frame has the
// upper room, islands apart from it stand below, side by side. Of more than six the rest is
// counted.
class SnapshotStage {
 public:
  // Islands without keyframes are passed over.
  void Observe(const MapSnapshot& snapshot);
  bool is_empty() const { return !global_.has_value() && apart_.empty(); }

  // Returns how high a snapshot of this width is.
  double Height(double width_px) const;
  void Draw(const MapSnapshot& snapshot, const Eigen::Vector2d& low_px, double width_px,
            Surface& surface) const;

 private:
  struct Place {
    MapView view;
    size_t keyframes = 0;
  };

  double GlobalHeight(double width_px) const;
  double ApartHeight(double width_px) const;
  // Returns where the `index`th island apart is drawn.
  Bounds ApartCell(size_t index, const Eigen::Vector2d& low_px, double width_px) const;
  size_t Shown() const;

  std::optional<Place> global_;
  std::map<uint64_t, Place> apart_;
};

struct SnapshotOptions {
  int width_px = 1200;
};

// Draws snapshots side by side, at most four in a row. INVALID_ARGUMENT without any keyframe, or
// for a width that is not 200 to 10,000.
absl::StatusOr<cv::Mat> RenderSnapshots(const std::vector<MapSnapshot>& snapshots,
                                        const SnapshotOptions& options = {});
absl::StatusOr<std::string> RenderSnapshotsSvg(const std::vector<MapSnapshot>& snapshots,
                                               const SnapshotOptions& options = {});

// Draws one frame of an animation; frames of the same stage and width have one size.
absl::StatusOr<cv::Mat> RenderFrame(const SnapshotStage& stage, const MapSnapshot& snapshot,
                                    const SnapshotOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_MAP_SNAPSHOTS_H_
