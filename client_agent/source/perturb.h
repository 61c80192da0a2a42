// Changes a picture as another camera or another hour of the day would.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_PERTURB_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_PERTURB_H_

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "absl/status/status.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// Applies gamma first, then noise. `image` is CV_8UC1; the same stream (frame and camera) gets the
// same noise each time, other streams get other noise. May throw cv::Exception.
cv::Mat Perturb(const cv::Mat& image, const Perturbation& perturbation, uint64_t stream);

// Perturbs the pictures of frame `number` of any sequence or stream; depth stays as it is. Returns
// INTERNAL, naming the frame, where OpenCV throws.
absl::Status PerturbImages(const Perturbation& perturbation, size_t number, SensorImages& images);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_PERTURB_H_
