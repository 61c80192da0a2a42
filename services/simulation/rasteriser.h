// Finds the samples of a picture that each face covers, after M. Olano and T. Greer, "Triangle scan
// conversion using 2D homogeneous coordinates" (Graphics Hardware 1997): nothing has to be cut
// where it passes the camera.
#ifndef CORBSLAM_SERVICES_SIMULATION_RASTERISER_H_
#define CORBSLAM_SERVICES_SIMULATION_RASTERISER_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "services/simulation/face_mesh.h"
#include "services/simulation/visibility_buffer.h"

namespace corbslam {

// A face of which at least one sample was seen when it was drawn.
struct DrawnFace {
  Eigen::Vector3f nearness;  // nearness . (x, y, 1) is that of the face's plane at pixel (x, y).
  uint32_t placement;        // The number given to DrawCluster.
  uint32_t patch;
};

// Maps the mesh's frame (x, y, z, 1) to depth times (pixel x, pixel y, 1), in metres and pixels.
using PixelFromMesh = Eigen::Matrix<float, 3, 4>;

// Where a box is seen in a picture of this size; nullopt: nowhere.
struct SeenBox {
  PixelRect rect;
  float nearness;  // Nearness of its nearest corner; kMostNearness where it reaches behind the
                   // camera.
};
std::optional<SeenBox> SeeBox(const Eigen::AlignedBox3f& box, const PixelFromMesh& pixel_from_mesh,
                              int width_px, int height_px);

// Draws the faces into the buffer and appends those seen. The bits are the same on every processor.
void DrawCluster(const FaceMesh& mesh, const FaceCluster& cluster,
                 const PixelFromMesh& pixel_from_mesh, uint32_t placement, VisibilityBuffer* buffer,
                 std::vector<DrawnFace>* drawn);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_RASTERISER_H_
