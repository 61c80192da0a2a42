// Takes pictures out of GStreamer's buffers.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_PICTURE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_PICTURE_H_

#include <gst/gst.h>

#include <opencv2/core/mat.hpp>
#include <optional>
#include <utility>

namespace corbslam::client_agent {

// Returns a copy of a sample's picture, GRAY8 as CV_8UC1, GRAY16_LE or GRAY16_BE as CV_16UC1;
// nullopt where the sample holds no such picture.
std::optional<cv::Mat> CopyPicture(GstSample* sample);

// Returns the left and right half (or the upper and lower one); a middle column or row that
// belongs to neither is left out.
std::pair<cv::Mat, cv::Mat> SplitPicture(const cv::Mat& picture, bool side_by_side);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_PICTURE_H_
