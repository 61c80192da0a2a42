// Draws pictures of a scene.
#ifndef CORBSLAM_SERVICES_SIMULATION_RENDERER_H_
#define CORBSLAM_SERVICES_SIMULATION_RENDERER_H_

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "services/simulation/lens.h"
#include "services/simulation/lens_view.h"
#include "services/simulation/scene.h"
#include "services/simulation/scene_faces.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// Where the camera is while some rows of a picture are exposed.
struct RowBand {
  Rigid3d world_from_camera = {};
  double time_s = 0;
};

// One picture to be taken.
struct Shot {
  Rigid3d world_from_camera = {};
  double time_s = 0;      // Time of the sequence, which says where the movers are.
  uint64_t stream = 0;    // Noise differs between streams: make one of frame and camera.
  double exposure = 1;    // Multiplies the lens's.
  double defocus_px = 0;  // Standard deviation of a blur that comes before the lens's own.
  double covered = 0;     // Share of the picture that a hand before the lens hides, from the right.
  // A rolling shutter: bands of equally many rows from the top, each at its own time and pose,
  // which go before those above. Of pinhole cameras only. Empty: all rows are exposed together.
  std::vector<RowBand> bands = {};
};

// Draws the same bytes for the same shot whatever the number of threads. Thread-safe.
class Renderer {
 public:
  // Meshes of instances and movers must be there, and movers have a path; `threads` changes speed
  // only.
  explicit Renderer(const Scene& scene, const Lens& lens = {}, int threads = 1)
      : scene_(scene), lens_(lens), threads_(threads) {}

  // Returns a CV_8UC1 picture of the camera's size.
  cv::Mat DrawGrey(const Camera& camera, const Shot& shot) const;
  // Draws what a camera of any lens sees; black where it sees nothing.
  cv::Mat DrawGrey(const LensView& view, const Shot& shot) const;
  // Returns a CV_32FC1 of the camera's size: z of the first surface at each pixel's centre in
  // metres, 0 where there is none.
  cv::Mat DrawDepth(const Camera& camera, const Shot& shot) const;

 private:
  using DrawRows = std::function<cv::Mat(const Camera&, const RowBand&)>;

  cv::Mat LightAt(const Camera& camera, const RowBand& when, int threads) const;
  cv::Mat DepthAt(const Camera& camera, const RowBand& when) const;
  // Draws each band with a camera that has its rows alone.
  cv::Mat DrawBands(const Camera& camera, const Shot& shot, const DrawRows& draw) const;
  // Returns the picture that the lens and the imager make of the light.
  cv::Mat Finish(const Shot& shot, cv::Mat light) const;

  const SceneFaces scene_;
  const Lens lens_;
  const int threads_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_RENDERER_H_
