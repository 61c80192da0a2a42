// Makes depth pictures, as their camera gives them, what sensors take.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_DEPTH_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_DEPTH_H_

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/rig/rig.h"
#include "slam/camera/depth_registration.h"

namespace corbslam::client_agent {

// Returns the two cameras of an RGB-D rig, whose depth has a camera of its own.
DepthGeometry DepthGeometryOf(const Rig& rig);

// Immutable, cheap to copy; any thread.
class DepthPreparation {
 public:
  DepthPreparation() = default;  // Leaves pictures as they are.

  // `registers` says whether depth is registered to the other camera's pictures. Nullopt: where
  // the rig has a camera of depth. False: it is already. INVALID_ARGUMENT where it is to be and the
  // rig lacks that camera, or where the rig is of a stereo pair.
  static absl::StatusOr<DepthPreparation> Make(const Rig& rig, std::optional<bool> registers);

  bool registers() const { return registration_ != nullptr; }
  // Returns the size that depth pictures have before they are prepared; nullopt where they are
  // registered already.
  std::optional<cv::Size> raw_size() const { return raw_size_; }
  // Says what is done, for people; empty: nothing.
  const std::string& description() const { return description_; }
  // Returns the picture without what the rig says is no depth, registered. Returns INVALID_ARGUMENT
  // as DepthRegistration does.
  absl::StatusOr<cv::Mat> Prepare(const cv::Mat& depth) const;

 private:
  double units_per_m_ = 0;
  std::vector<double> no_depth_;
  std::optional<cv::Size> raw_size_;
  std::string description_;
  std::shared_ptr<const DepthRegistration> registration_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_DEPTH_H_
