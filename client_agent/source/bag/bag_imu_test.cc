// Tests what bags give of an IMU. Messages of one are put into a bag that others wrote.
#include "client_agent/source/bag/bag_imu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/bag_source.h"
#include "client_agent/source/bag/bag_summary.h"
#include "client_agent/source/bag/testing/drawn_bags.h"
#include "client_agent/source/recorded_sequence.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Fields as MCAP and little-endian CDR have them.
class LittleBytes {
 public:
  template <typename Number>
  LittleBytes& Put(Number number) {
    char raw[sizeof(number)];
    std::memcpy(raw, &number, sizeof(number));
    bytes_.append(raw, sizeof(number));
    return *this;
  }
  // CDR aligns numbers to their size; of a text the zero counts.
  template <typename Number>
  LittleBytes& Aligned(Number number) {
    bytes_.resize((bytes_.size() + sizeof(number) - 1) / sizeof(number) * sizeof(number));
    return Put(number);
  }
  LittleBytes& Text(const std::string& text) {
    Put(static_cast<uint32_t>(text.size()));
    bytes_ += text;
    return *this;
  }
  LittleBytes& CdrText(const std::string& text) {
    Aligned(static_cast<uint32_t>(text.size() + 1));
    bytes_ += text + '\0';
    return *this;
  }
  const std::string& bytes() const { return bytes_; }
  std::string AsCdr() const { return std::string("\0\1\0\0", 4) + bytes_; }

 private:
  std::string bytes_;
};

std::string McapRecord(uint8_t op, const std::string& content) {
  return LittleBytes().Put(op).Put(uint64_t{content.size()}).bytes() + content;
}

std::string McapTopic(uint16_t id, const std::string& topic, const std::string& type) {
  return McapRecord(3, LittleBytes().Put(id).Text(type).Text("ros2msg").Text("").bytes()) +
         McapRecord(4, LittleBytes().Put(id).Put(id).Text(topic).Text("cdr").Text("").bytes());
}

std::string McapMessage(uint16_t id, int64_t recorded_ns, const std::string& data) {
  const auto time = static_cast<uint64_t>(recorded_ns);
  return McapRecord(5, LittleBytes().Put(id).Put(uint32_t{0}).Put(time).Put(time).bytes() + data);
}

LittleBytes HeaderOf(int64_t stamp_ns, const std::string& frame) {
  return LittleBytes()
      .Put(static_cast<int32_t>(stamp_ns / 1'000'000'000))
      .Put(static_cast<uint32_t>(stamp_ns % 1'000'000'000))
      .CdrText(frame);
}

std::string ImuData(const ImuSample& sample, const std::string& frame) {
  LittleBytes bytes = HeaderOf(sample.timestamp_ns, frame);
  for (int i = 0; i < 13; ++i) bytes.Aligned(i == 3 ? 1.0 : 0.0);
  for (const double number : sample.angular_velocity_rps) bytes.Aligned(number);
  for (int i = 0; i < 9; ++i) bytes.Aligned(0.0);
  for (const double number : sample.specific_force_mps2) bytes.Aligned(number);
  for (int i = 0; i < 9; ++i) bytes.Aligned(0.0);
  return bytes.AsCdr();
}

// Says that the left camera of the drawn pair sits 5 cm from the IMU.
std::string FixedFrames(const std::string& camera_frame) {
  LittleBytes bytes;
  bytes.Put(uint32_t{1});
  bytes.Put(int32_t{0}).Put(uint32_t{0}).CdrText("imu_link").CdrText(camera_frame);
  for (const double number : {0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) bytes.Aligned(number);
  return McapTopic(90, "/tf_static", "tf2_msgs/msg/TFMessage") +
         McapMessage(90, kDrawnStart_ns, bytes.AsCdr());
}

ImuSample SampleOf(int i) {
  const double t = 0.005 * i;
  return {kDrawnStart_ns - 20'000'000 + i * 5'000'000,
          {0.3 * std::sin(3 * t), 1e-3 * i, 0.1 * std::cos(t)},
          {0.2 * std::cos(2 * t), -9.8 + 0.1 * std::sin(5 * t), 0.1 * std::sin(t)}};
}

// Returns 80 messages of an IMU on a topic: from 20 ms before the first of three frames to 175 ms
// behind the last.
std::string ImuTopic(uint16_t id, const std::string& topic, const std::string& frame = "imu_link") {
  std::string records = McapTopic(id, topic, "sensor_msgs/msg/Imu");
  for (int i = 0; i < 80; ++i) {
    const ImuSample sample = SampleOf(i);
    records += McapMessage(id, sample.timestamp_ns + 1'000'000, ImuData(sample, frame));
  }
  return records;
}

// Puts records behind the first one of the drawn pair's bag.
std::string BagWith(const std::string& name, const std::string& records) {
  std::string bytes = ReadBytes(DrawnBag("stereo_unchunked.mcap"));
  uint64_t first_size = 0;
  std::memcpy(&first_size, bytes.data() + 9, sizeof(first_size));
  bytes.insert(8 + 9 + first_size, records);
  return WriteBytes(name, bytes);
}

constexpr char kCameraFrame[] = "stereo_left";

absl::StatusOr<std::unique_ptr<FrameReader>> OpenSpec(const std::string& bag) {
  RegisterBagSource();
  const auto spec = ParseSourceSpec("bag:" + bag);
  if (!spec.ok()) return spec.status();
  return OpenReader(*spec);
}

std::optional<ImuCalibration> BagsImu(const FrameReader& reader) {
  return std::visit([](const auto& kind) { return kind.imu; }, reader.calibration());
}

TEST(BagImuTest, FramesHaveWhatWasMeasuredAndTheFixedFramesSayWhere) {
  const std::string bag =
      BagWith("one_imu.mcap", FixedFrames(kCameraFrame) + ImuTopic(91, "/imu/data"));
  const auto reader = OpenSpec(bag);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_THAT((*reader)->description().remarks.findings, IsEmpty());
  const auto imu = BagsImu(**reader);
  ASSERT_TRUE(imu.has_value()) << (*reader)->description().remarks.left_out[0];
  EXPECT_LT((imu->imu_from_camera.translation - Eigen::Vector3d(0.05, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(imu->rate_hz, 200, 1e-6);
  EXPECT_THAT((*reader)->description().imu, HasSubstr("200 Hz, 80 samples"));
  EXPECT_THAT((*reader)->description().imu, HasSubstr("one_imu.mcap: /imu/data"));
  const auto sequence = OpenSource("bag:" + bag);
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  std::vector<size_t> counts;
  int next = 0;
  for (int i = 0; i < 3; ++i) {
    const auto images = (*sequence)->NextImages();
    ASSERT_TRUE(images.ok() && images->has_value()) << images.status();
    counts.push_back((*images)->imu.size());
    for (const ImuSample& sample : (*images)->imu) {
      const ImuSample sent = SampleOf(next++);
      EXPECT_EQ(sample.timestamp_ns, sent.timestamp_ns);
      EXPECT_EQ(sample.angular_velocity_rps, sent.angular_velocity_rps);
      EXPECT_EQ(sample.specific_force_mps2, sent.specific_force_mps2);
    }
  }
  EXPECT_THAT(counts, ElementsAre(5, 20, 20));
}

TEST(BagImuTest, SeveralMustBeNamed) {
  const std::string bag =
      BagWith("two_imus.mcap",
              FixedFrames(kCameraFrame) + ImuTopic(91, "/imu/data") + ImuTopic(92, "/camera/imu"));
  auto reader = OpenSpec(bag);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_FALSE(BagsImu(**reader).has_value());
  EXPECT_THAT((*reader)->description().remarks.left_out,
              ElementsAre(HasSubstr("say which by ?imu=/camera/imu, ?imu=/imu/data")));
  reader = OpenSpec(bag + "?imu=camera/imu");
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_TRUE(BagsImu(**reader).has_value());
  EXPECT_THAT((*reader)->description().imu, HasSubstr("/camera/imu"));
  EXPECT_THAT(std::string(OpenSpec(bag + "?imu=/other").status().message()),
              HasSubstr("?imu=/other: no topic of sensor_msgs/Imu with messages; there are "
                        "/camera/imu, /imu/data"));
  reader = OpenSpec(bag + "?imu=0");
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_THAT((*reader)->description().remarks.left_out, IsEmpty());
  EXPECT_EQ(FormatSourceSpec(*ParseSourceSpec("bag:A?imu=a")), "bag:A?imu=/a");
  EXPECT_THAT(std::string(ParseSourceSpec("bag:A?imu").status().message()),
              HasSubstr("a topic, or 0 for none"));
}

TEST(BagImuTest, WithoutAPlaceItIsLeftOutOrTheRigSaysIt) {
  const std::string bag = BagWith("unplaced_imu.mcap", ImuTopic(91, "/imu/data"));
  auto reader = OpenSpec(bag);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_FALSE(BagsImu(**reader).has_value());
  EXPECT_THAT((*reader)->description().remarks.left_out,
              ElementsAre(HasSubstr("nobody says where it sits (there is no /tf_static)")));
  EXPECT_THAT(std::string(OpenSpec(bag + "?imu=/imu/data").status().message()),
              HasSubstr("unplaced_imu.mcap: /imu/data: the IMU can't be taken: nobody says where"));
  const std::string rig = WriteBytes("bag_imu_rig.yaml", R"(rig: 1
kind: stereo
rectified: true
baseline_m: 0.1
cameras:
  - {size_px: [40, 30], focal_px: [41, 41], principal_px: [20, 15]}
  - {size_px: [40, 30], focal_px: [41, 41], principal_px: [20, 15]}
imu: {imu_from_camera: [1, 0, 0, 0.02, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], time_offset_s: 0.001}
)");
  reader = OpenSpec(bag + "?rig=" + rig);
  ASSERT_TRUE(reader.ok()) << reader.status();
  ASSERT_TRUE(BagsImu(**reader).has_value());
  EXPECT_EQ(BagsImu(**reader)->imu_from_camera.translation.x(), 0.02);
  const ImuSamples first = (*reader)->Imu(0, kDrawnStart_ns);
  ASSERT_FALSE(first.empty());
  EXPECT_EQ(first.front().timestamp_ns, SampleOf(0).timestamp_ns + 1'000'000);
  // A rig's IMU without a topic.
  reader = OpenSpec(DrawnBag("stereo_zstd.mcap") + "?rig=" + rig);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_FALSE(BagsImu(**reader).has_value());
  EXPECT_THAT((*reader)->description().remarks.left_out,
              ElementsAre(HasSubstr("the rig's IMU, of which the bag has no samples")));
}

TEST(BagImuTest, TellsWhatIsNoMeasurement) {
  ImuSample bad = SampleOf(100);
  bad.angular_velocity_rps.x() = std::numeric_limits<double>::quiet_NaN();
  const std::string cut = ImuData(SampleOf(101), "imu_link").substr(0, 100);
  const std::string bag =
      BagWith("bad_imu.mcap", FixedFrames(kCameraFrame) + ImuTopic(91, "/imu/data") +
                                  McapMessage(91, kDrawnStart_ns, ImuData(bad, "imu_link")) +
                                  McapMessage(91, kDrawnStart_ns, cut) +
                                  McapMessage(91, kDrawnStart_ns, ImuData(SampleOf(102), "other")));
  const auto reader = OpenSpec(bag);
  ASSERT_TRUE(reader.ok()) << reader.status();
  std::vector<std::string> codes;
  for (const SourceFinding& finding : (*reader)->description().remarks.findings) {
    codes.push_back(finding.code);
  }
  EXPECT_THAT(codes, ElementsAre("imu-unreadable", "imu-two-frames"));
  EXPECT_THAT((*reader)->description().remarks.findings[0].text, HasSubstr("2 of 83 messages"));
}

TEST(BagImuTest, TheSummaryNamesIt) {
  BagOptions options;
  options.path = BagWith("summed_imu.mcap", FixedFrames(kCameraFrame) + ImuTopic(91, "/imu/data"));
  const auto summary = SummariseBag(options);
  ASSERT_TRUE(summary.ok()) << summary.status();
  const std::string text = FormatBagSummary(*summary);
  EXPECT_THAT(text, HasSubstr("an IMU's, frame 'imu_link'"));
  EXPECT_THAT(text, HasSubstr("imu: 200 Hz, 80 samples"));
}

}  // namespace
}  // namespace corbslam::client_agent
