// Chooses the modes of OpenNI 2's cameras, and takes pictures out of their frames.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_PICTURE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_PICTURE_H_

#include <OpenNI.h>

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace corbslam::client_agent {

// For messages: "640x480 at 30/s, format 100", and all that a sensor has.
std::string DescribeMode(const openni::VideoMode& mode);
std::string ListModes(const openni::SensorInfo& sensor);

// Returns the mode of that size, in a format that ToGrey or ToDepth takes, whose rate is nearest to
// what is wanted, or the fastest. Null where there is none.
const openni::VideoMode* ChooseMode(const openni::SensorInfo& sensor, const cv::Size& size,
                                    std::optional<double> rate_hz);

// They return copies: CV_8UC1 of RGB888, GRAY8, YUV422 and YUYV, and CV_16UC1. Empty for another
// format of colour.
cv::Mat ToGrey(const openni::VideoFrameRef& frame);
cv::Mat ToDepth(const openni::VideoFrameRef& frame);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_PICTURE_H_
