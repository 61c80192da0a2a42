// The bags of tests/data/bags, which tests/interchange/bags/make_test_bags.sh writes: three frames
// of 40x30 pixels, 0.1 s apart. For tests only.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_TESTING_DRAWN_BAGS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_TESTING_DRAWN_BAGS_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <opencv2/core/mat.hpp>
#include <string>

namespace corbslam::client_agent {

inline constexpr int64_t kDrawnStart_ns = 1'600'000'000'000'000'000;

// Each holds the same stereo pair.
inline constexpr const char* kStereoBags[] = {
    "stereo_none.bag",  "stereo_bz2.bag",  "stereo_lz4.bag",        "stereo_none.mcap",
    "stereo_zstd.mcap", "stereo_lz4.mcap", "stereo_unchunked.mcap", "stereo_png.mcap",
    "stereo_split",     "stereo_packed"};

inline std::string DrawnBag(const std::string& name) {
  return std::string(CORBSLAM_TEST_BAGS) + "/" + name;
}

// Returns the picture of a frame; `side` is 0 of the left camera, and of the RGB-D one, 1 of the
// right one.
inline cv::Mat DrawnPicture(int frame, int side) {
  cv::Mat picture(30, 40, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      picture.at<uint8_t>(y, x) =
          static_cast<uint8_t>((7 * x + 13 * y + 31 * frame + 101 * side) % 256);
    }
  }
  return picture;
}

inline std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline std::string WriteBytes(const std::string& name, const std::string& bytes) {
  std::string path = ::testing::TempDir() + "/" + name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_TESTING_DRAWN_BAGS_H_
