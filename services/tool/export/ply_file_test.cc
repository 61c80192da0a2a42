#include "services/tool/export/ply_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(PlyFileTest, HasFifteenBytesAPointBehindTheHeader) {
  const std::string path = TestPath("points.ply");
  const std::vector<ColouredPoint> points = {{{1.5, -2, 1e4}, {1, 2, 3}}, {{0, 0, 0}, {255, 0, 7}}};
  ASSERT_TRUE(WritePly(points, {"alpha #010203"}, path).ok());
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const size_t header = text.find("end_header\n") + 11;
  EXPECT_EQ(text.substr(0, header),
            "ply\nformat binary_little_endian 1.0\ncomment alpha #010203\nelement vertex 2\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n");
  ASSERT_EQ(text.size(), header + 2 * 15);
  float x = 0;
  float z = 0;
  std::memcpy(&x, text.data() + header, sizeof(x));
  std::memcpy(&z, text.data() + header + 8, sizeof(z));
  EXPECT_EQ(x, 1.5F);
  EXPECT_EQ(z, 1e4F);
  EXPECT_EQ(text.substr(header + 12, 3), "\x01\x02\x03");
  EXPECT_EQ(text.substr(header + 27, 3), std::string("\xff\x00\x07", 3));
}

TEST(PlyFileTest, SaysWhatItCantWrite) {
  EXPECT_THAT(std::string(WritePly({}, {}, "/nowhere/a.ply").message()),
              HasSubstr("/nowhere/a.ply"));
}

}  // namespace
}  // namespace corbslam::services
