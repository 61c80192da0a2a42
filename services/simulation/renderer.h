// Draws pictures of a scene.
#ifndef CORBSLAM_SERVICES_SIMULATION_RENDERER_H_
#define CORBSLAM_SERVICES_SIMULATION_RENDERER_H_

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "services/simulation/lens.h"
#include "services/simulation/lens_view.h"
#include "services/simulation/scene.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

struct RenderOptions {
  Lens lens;
  int threads = 1;  // Changes speed only.
};

// Where the camera is while some rows of a picture are exposed.
struct RowBand {
  Rigid3d world_from_camera = {};
  std::optional<Rigid3d> world_from_camera_at_close = {};
  double time_s = 0;
};

// One picture to be taken.
struct Shot {
  Rigid3d world_from_camera = {};
  // Pose of the camera when the shutter closes; motion blur is drawn from it.
  std::optional<Rigid3d> world_from_camera_at_close = {};
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
  // INVALID_ARGUMENT names the field, for a mesh index out of range, an empty mover path or numbers
  // that aren't finite.
  static absl::StatusOr<std::unique_ptr<Renderer>> Make(const Scene& scene,
                                                        const RenderOptions& options);
  virtual ~Renderer() = default;

  // Returns a CV_8UC1 picture of the camera's size.
  virtual cv::Mat DrawGrey(const Camera& camera, const Shot& shot) const = 0;
  // Draws what a camera of any lens sees; black where it sees nothing.
  virtual cv::Mat DrawGrey(const LensView& view, const Shot& shot) const = 0;
  // Returns a CV_32FC1 of the camera's size: z of the first surface at each pixel's centre in
  // metres, 0 where there is none.
  virtual cv::Mat DrawDepth(const Camera& camera, const Shot& shot) const = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_RENDERER_H_
