#include "client_agent/live/gstreamer/gst_picture.h"

#include <gst/video/video.h>

#include <opencv2/core.hpp>

namespace corbslam::client_agent {

std::optional<cv::Mat> CopyPicture(GstSample* sample) {
  GstVideoInfo info;
  const GstCaps* caps = gst_sample_get_caps(sample);
  GstBuffer* buffer = gst_sample_get_buffer(sample);
  if (caps == nullptr || buffer == nullptr || gst_video_info_from_caps(&info, caps) == FALSE) {
    return std::nullopt;
  }
  const GstVideoFormat format = GST_VIDEO_INFO_FORMAT(&info);
  if (format != GST_VIDEO_FORMAT_GRAY8 && format != GST_VIDEO_FORMAT_GRAY16_LE &&
      format != GST_VIDEO_FORMAT_GRAY16_BE) {
    return std::nullopt;
  }
  GstVideoFrame frame;
  if (gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ) == FALSE) return std::nullopt;
  const cv::Mat view(GST_VIDEO_FRAME_HEIGHT(&frame), GST_VIDEO_FRAME_WIDTH(&frame),
                     format == GST_VIDEO_FORMAT_GRAY8 ? CV_8UC1 : CV_16UC1,
                     GST_VIDEO_FRAME_PLANE_DATA(&frame, 0),
                     static_cast<size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)));
  cv::Mat copy = view.clone();
  gst_video_frame_unmap(&frame);
  if (format == GST_VIDEO_FORMAT_GRAY16_BE) {
    for (auto pixel = copy.begin<uint16_t>(); pixel != copy.end<uint16_t>(); ++pixel) {
      *pixel = static_cast<uint16_t>(*pixel << 8 | *pixel >> 8);
    }
  }
  return copy;
}

std::pair<cv::Mat, cv::Mat> SplitPicture(const cv::Mat& picture, bool side_by_side) {
  if (side_by_side) {
    const int half = picture.cols / 2;
    return {picture.colRange(0, half).clone(),
            picture.colRange(picture.cols - half, picture.cols).clone()};
  }
  const int half = picture.rows / 2;
  return {picture.rowRange(0, half).clone(),
          picture.rowRange(picture.rows - half, picture.rows).clone()};
}

}  // namespace corbslam::client_agent
