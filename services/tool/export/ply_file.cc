#include "services/tool/export/ply_file.h"

#include <array>
#include <bit>

#include "absl/strings/str_cat.h"
#include "slam/util/atomic_file.h"

namespace corbslam::services {
namespace {

static_assert(std::endian::native == std::endian::little, "the file's numbers are little-endian");

std::string MakeHeader(size_t points, const std::vector<std::string>& comments) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) absl::StrAppend(&header, "comment ", comment, "\n");
  absl::StrAppend(&header, "element vertex ", points, "\n");
  for (const char* axis : {"x", "y", "z"}) absl::StrAppend(&header, "property float ", axis, "\n");
  for (const char* channel : {"red", "green", "blue"}) {
    absl::StrAppend(&header, "property uchar ", channel, "\n");
  }
  return header + "end_header\n";
}

}  // namespace

absl::Status WritePly(const std::vector<ColouredPoint>& points,
                      const std::vector<std::string>& comments, const std::string& path) {
  std::string text = MakeHeader(points.size(), comments);
  for (const ColouredPoint& point : points) {
    const Eigen::Vector3f position = point.position.cast<float>();
    const std::array<uint8_t, 3> colour = {point.colour.red, point.colour.green, point.colour.blue};
    text.append(reinterpret_cast<const char*>(position.data()), 3 * sizeof(float));
    text.append(reinterpret_cast<const char*>(colour.data()), colour.size());
  }
  return WriteAtomically(path, text);
}

}  // namespace corbslam::services
