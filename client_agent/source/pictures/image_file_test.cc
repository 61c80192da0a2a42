#include "client_agent/source/pictures/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

std::string PathOf(const std::string& name) {
  const std::string folder = ::testing::TempDir() + "/image_file_test";
  std::filesystem::create_directories(folder);
  return folder + "/" + name;
}

std::string WriteBytes(const std::string& name, const std::string& bytes) {
  std::ofstream(PathOf(name), std::ios::binary) << bytes;
  return PathOf(name);
}

// Returns a picture that is brighter to the right and downwards, so that a turned one is another.
cv::Mat Slope(int type, double step) {
  cv::Mat image(48, 64, type);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double value = step * (x + 2 * y);
      if (type == CV_16UC1) {
        image.at<uint16_t>(y, x) = static_cast<uint16_t>(value);
      } else {
        image.at<uint8_t>(y, x) = static_cast<uint8_t>(value);
      }
    }
  }
  return image;
}

std::string Encode(const std::string& ending, const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  cv::imencode(ending, image, bytes);
  return std::string(bytes.begin(), bytes.end());
}

// Adds an EXIF segment that holds nothing but an orientation, behind the JPEG's first marker.
std::string WithOrientation(const std::string& jpeg, char orientation) {
  using namespace std::string_literals;
  const std::string exif = "\xff\xe1\x00\x22"s + "Exif\0\0"s + "MM\0*\0\0\0\x08"s + "\0\x01"s +
                           "\x01\x12\0\x03\0\0\0\x01\0"s + std::string(1, orientation) + "\0\0"s +
                           "\0\0\0\0"s;
  return jpeg.substr(0, 2) + exif + jpeg.substr(2);
}

TEST(ReadGreyImageTest, ReadsPixelsAsTheyAreStoredWhateverExifSays) {
  const std::string jpeg = Encode(".jpg", Slope(CV_8UC1, 1.5));
  const cv::Mat plain = *ReadGreyImage(WriteBytes("plain.jpg", jpeg));
  for (const char orientation : {char{2}, char{3}, char{6}, char{8}}) {
    const std::string path =
        WriteBytes(absl::StrCat("o", int{orientation}, ".jpg"), WithOrientation(jpeg, orientation));
    const cv::Mat turned = cv::imread(path, cv::IMREAD_GRAYSCALE);
    ASSERT_TRUE(turned.size() != plain.size() || cv::norm(turned, plain, cv::NORM_INF) > 20)
        << "the test's EXIF says nothing";
    const auto read = ReadGreyImage(path);
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(read->size(), plain.size());
    EXPECT_EQ(cv::norm(*read, plain, cv::NORM_INF), 0) << int{orientation};
  }
}

TEST(ReadGreyImageTest, Keeps16Bits) {
  const cv::Mat image = Slope(CV_16UC1, 300);
  const auto read = ReadGreyImage(WriteBytes("grey16.png", Encode(".png", image)));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(cv::norm(*read, image, cv::NORM_INF), 0);
}

TEST(ReadGreyImageTest, MakesColourGrey) {
  const cv::Mat colour(20, 30, CV_8UC3, cv::Scalar(10, 100, 200));
  const auto read = ReadGreyImage(WriteBytes("colour.png", Encode(".png", colour)));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->type(), CV_8UC1);
}

TEST(ReadGreyImageTest, TakesAPictureWithPaddingBehindItsEnd) {
  for (const char* ending : {".jpg", ".png"}) {
    const std::string bytes = Encode(ending, Slope(CV_8UC1, 1.5)) + std::string(512, '\0');
    EXPECT_TRUE(ReadGreyImage(WriteBytes(absl::StrCat("padded", ending), bytes)).ok()) << ending;
  }
}

struct Broken {
  const char* name;
  double kept;  // Share of the bytes.
};
class CutPictureTest : public ::testing::TestWithParam<Broken> {};

TEST_P(CutPictureTest, IsNamedAndNotTaken) {
  const std::string ending = std::filesystem::path(GetParam().name).extension();
  const std::string bytes = Encode(ending, Slope(CV_8UC1, 1.5));
  const auto kept = static_cast<size_t>(GetParam().kept * static_cast<double>(bytes.size()));
  const std::string path = WriteBytes(GetParam().name, bytes.substr(0, kept));
  const absl::Status status = ReadGreyImage(path).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(path));
}

INSTANTIATE_TEST_SUITE_P(All, CutPictureTest,
                         ::testing::Values(Broken{"half.jpg", 0.5}, Broken{"most.jpg", 0.95},
                                           Broken{"half.png", 0.5}, Broken{"most.png", 0.95},
                                           Broken{"none.png", 0}, Broken{"none.jpg", 0},
                                           Broken{"half.bmp", 0.5}, Broken{"half.pgm", 0.5},
                                           Broken{"half.tif", 0.5}),
                         testing::NamedBy(&Broken::name));

TEST(ReadGreyImageTest, NamesWhatIsNoPicture) {
  const std::string path = WriteBytes("text.png", "not a picture\n");
  EXPECT_THAT(std::string(ReadGreyImage(path).status().message()), HasSubstr(path));
  EXPECT_TRUE(absl::IsNotFound(ReadGreyImage(PathOf("nowhere.png")).status()));
}

TEST(ReadDepthImageTest, RefusesAGreyPicture) {
  const std::string path = WriteBytes("grey8.png", Encode(".png", Slope(CV_8UC1, 1)));
  EXPECT_THAT(std::string(ReadDepthImage(path).status().message()),
              HasSubstr("one channel of 16 bits, this one is of OpenCV type CV_8UC1"));
}

}  // namespace
}  // namespace corbslam::client_agent
