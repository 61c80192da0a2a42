// Makes up bytes that have the form of a grey JPEG, without a picture in them.
#ifndef CORBSLAM_MAP_STORE_TESTING_GREY_JPEG_H_
#define CORBSLAM_MAP_STORE_TESTING_GREY_JPEG_H_

#include <cstddef>
#include <cstdint>
#include <string>

namespace corbslam::testing {

// Returns a whole JPEG by its headers: a comment, a frame's header of this size, precision and
// number of colours, and a scan of `scan_bytes`.
inline std::string MakeGreyJpeg(int width, int height, size_t scan_bytes, int bits = 8,
                                int colours = 1) {
  std::string jpeg("\xff\xd8\xff\xfe\x00\x04hi\xff\xc0\x00\x0b", 12);
  for (const int byte : {bits, height >> 8, height, width >> 8, width, colours, 1, 0x11, 0}) {
    jpeg.push_back(static_cast<char>(byte));
  }
  jpeg.append("\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00", 10);
  jpeg.append(scan_bytes, '\x5a');
  return jpeg + "\xff\xd9";
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_GREY_JPEG_H_
