#include "client_agent/source/bag/messages/ros_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <tuple>

#include "client_agent/source/bag/messages/transforms.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// How a message is made bytes: the three ways that bags hold.
enum class Form { kRos1, kCdrLittle, kCdrBig };
constexpr Form kForms[] = {Form::kRos1, Form::kCdrLittle, Form::kCdrBig};

BagEncoding EncodingOf(Form form) {
  return form == Form::kRos1 ? BagEncoding::kRos1 : BagEncoding::kCdr;
}

class Writer {
 public:
  explicit Writer(Form form) : form_(form) {}

  template <typename Number>
  Writer& Put(Number number) {
    if (form_ != Form::kRos1)
      bytes_.resize((bytes_.size() + sizeof(number) - 1) / sizeof(number) * sizeof(number));
    char raw[sizeof(number)];
    std::memcpy(raw, &number, sizeof(number));
    if (form_ == Form::kCdrBig) std::reverse(raw, raw + sizeof(number));
    bytes_.append(raw, sizeof(number));
    return *this;
  }
  Writer& Text(const std::string& text) {
    const bool is_ros1 = form_ == Form::kRos1;
    Put(static_cast<uint32_t>(text.size() + (is_ros1 ? 0 : 1)));
    bytes_ += text;
    if (!is_ros1) bytes_ += '\0';
    return *this;
  }
  Writer& Header(const std::string& frame) {
    if (form_ == Form::kRos1) Put(uint32_t{7});
    return Put(uint32_t{12}).Put(uint32_t{34}).Text(frame);
  }
  std::string bytes() const {
    if (form_ == Form::kRos1) return bytes_;
    return std::string("\0", 1) + (form_ == Form::kCdrBig ? '\0' : '\1') + std::string(2, '\0') +
           bytes_;
  }

 private:
  Form form_;
  std::string bytes_;
};

std::string ImageBytes(Form form) {
  Writer writer(form);
  writer.Header("/optical").Put(uint32_t{1}).Put(uint32_t{3}).Text("mono8").Put(uint8_t{0});
  return writer.Put(uint32_t{3}).Text("abc").bytes();
}

TEST(RosMessagesTest, AnImageIsReadInEachForm) {
  for (const Form form : kForms) {
    const std::string bytes = ImageBytes(form);
    const auto image = ReadRosImage(EncodingOf(form), bytes);
    ASSERT_TRUE(image.ok()) << image.status();
    EXPECT_EQ(image->header.stamp_ns, 12'000'000'034);
    EXPECT_EQ(image->header.frame_id, "optical");
    EXPECT_EQ(image->height_px, 1u);
    EXPECT_EQ(image->width_px, 3u);
    EXPECT_EQ(image->encoding, "mono8");
    EXPECT_EQ(image->step, 3u);
    EXPECT_EQ(image->data.substr(0, 3), "abc");
  }
}

TEST(RosMessagesTest, AMessageThatIsCutShortNamesTheField) {
  for (const Form form : kForms) {
    const std::string bytes = ImageBytes(form);
    // A text's last zero is more than its bytes.
    const size_t whole = bytes.size() - (form == Form::kRos1 ? 0 : 1);
    for (size_t size = 0; size < whole; ++size) {
      const auto image = ReadRosImage(EncodingOf(form), bytes.substr(0, size));
      EXPECT_FALSE(image.ok()) << size;
    }
    const auto image = ReadRosImage(EncodingOf(form), bytes.substr(0, bytes.size() - 3));
    EXPECT_THAT(image.status().message(), HasSubstr("within its field data"));
  }
}

TEST(RosMessagesTest, AnotherRepresentationIsRefused) {
  std::string bytes = ImageBytes(Form::kCdrLittle);
  bytes[1] = 3;
  EXPECT_THAT(ReadRosImage(BagEncoding::kCdr, bytes).status().message(), HasSubstr("0x0003"));
  EXPECT_THAT(ReadRosImage(BagEncoding::kOther, bytes).status().message(), HasSubstr("neither"));
}

TEST(RosMessagesTest, ACalibrationIsReadInEachForm) {
  for (const Form form : kForms) {
    Writer writer(form);
    writer.Header("c").Put(uint32_t{30}).Put(uint32_t{40}).Text("plumb_bob").Put(uint32_t{2});
    writer.Put(0.5).Put(-0.25);
    for (int i = 0; i < 9 + 9 + 12; ++i) writer.Put(i + 0.5);
    for (uint32_t i = 0; i < 6; ++i) writer.Put(i);
    const std::string bytes = writer.Put(uint8_t{1}).bytes();
    const auto info = ReadRosCameraInfo(EncodingOf(form), bytes);
    ASSERT_TRUE(info.ok()) << info.status();
    EXPECT_THAT(info->d, ElementsAre(0.5, -0.25));
    EXPECT_EQ(info->k[8], 8.5);
    EXPECT_EQ(info->r[0], 9.5);
    EXPECT_EQ(info->p[11], 29.5);
    EXPECT_EQ(info->binning_y, 1u);
    EXPECT_EQ(info->roi_width_px, 5u);
  }
}

TEST(RosMessagesTest, WhatAnImuMeasuredIsReadInEachForm) {
  for (const Form form : kForms) {
    Writer writer(form);
    writer.Header("imu");
    for (int i = 0; i < 4 + 9 + 3 + 9 + 3 + 9; ++i) writer.Put(i + 0.5);
    const std::string bytes = writer.bytes();
    const auto imu = ReadRosImu(EncodingOf(form), bytes);
    ASSERT_TRUE(imu.ok()) << imu.status();
    EXPECT_EQ(imu->header.stamp_ns, 12'000'000'034);
    EXPECT_EQ(imu->header.frame_id, "imu");
    EXPECT_EQ(imu->angular_velocity_rps, Eigen::Vector3d(13.5, 14.5, 15.5));
    EXPECT_EQ(imu->linear_acceleration_mps2, Eigen::Vector3d(25.5, 26.5, 27.5));
    // The last covariance is not read.
    EXPECT_TRUE(ReadRosImu(EncodingOf(form), bytes.substr(0, bytes.size() - 72)).ok());
    EXPECT_THAT(ReadRosImu(EncodingOf(form), bytes.substr(0, bytes.size() - 73)).status().message(),
                HasSubstr("within its field linear_acceleration"));
  }
}

TEST(RosMessagesTest, ACountIsNotTakenByItsWord) {
  for (const Form form : kForms) {
    Writer writer(form);
    writer.Header("c").Put(uint32_t{30}).Put(uint32_t{40}).Text("plumb_bob").Put(UINT32_MAX);
    const auto info = ReadRosCameraInfo(EncodingOf(form), writer.bytes());
    EXPECT_THAT(info.status().message(), HasSubstr("within its field D"));
    EXPECT_FALSE(ReadRosTransforms(EncodingOf(form), Writer(form).Put(UINT32_MAX).bytes()).ok());
  }
}

std::string TransformBytes(Form form, const std::string& parent, const std::string& child, double x,
                           double qw) {
  Writer writer(form);
  writer.Put(uint32_t{1}).Header(parent).Text(child).Put(x).Put(0.0).Put(0.0);
  return writer.Put(0.0).Put(0.0).Put(0.0).Put(qw).bytes();
}

TEST(RosMessagesTest, TransformsMakeATree) {
  for (const Form form : kForms) {
    TransformTree tree;
    for (const auto& [parent, child, x] :
         {std::tuple("/base", "mast", 1.0), {"mast", "/left", 0.1}, {"mast", "right", -0.2}}) {
      const auto read =
          ReadRosTransforms(EncodingOf(form), TransformBytes(form, parent, child, x, 1));
      ASSERT_TRUE(read.ok()) << read.status();
      ASSERT_EQ(read->size(), 1u);
      tree.Add(read->front());
    }
    const auto motion = tree.TargetFromSource("right", "left");
    ASSERT_TRUE(motion.has_value());
    EXPECT_NEAR(motion->translation.x(), 0.3, 1e-12);
    EXPECT_NEAR(tree.TargetFromSource("base", "right")->translation.x(), 0.8, 1e-12);
    EXPECT_FALSE(tree.TargetFromSource("left", "elsewhere").has_value());
    const auto none = ReadRosTransforms(EncodingOf(form), TransformBytes(form, "a", "b", 1, 0));
    ASSERT_TRUE(none.ok());
    EXPECT_TRUE(none->empty()) << "no rotation";
  }
}

TEST(RosMessagesTest, ARingOfFramesEnds) {
  TransformTree tree;
  tree.Add({"a", "b", {}});
  tree.Add({"b", "a", {}});
  EXPECT_TRUE(tree.TargetFromSource("a", "b").has_value());
  EXPECT_FALSE(tree.TargetFromSource("a", "c").has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
