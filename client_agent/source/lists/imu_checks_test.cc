#include "client_agent/source/lists/imu_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int64_t kInterval_ns = 5'000'000;
constexpr int64_t kBegin_ns = 1'403'715'273'000'000'000;

// Ten seconds of a device that is carried about, at 200 Hz.
ImuSamples CarriedImu() {
  ImuSamples samples;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.005 * i;
    samples.push_back({kBegin_ns + i * kInterval_ns,
                       {0.4 * std::sin(2 * t), 0.3 * std::cos(3 * t), 0.1 * std::sin(t)},
                       {0.5 * std::sin(5 * t), 9.7 + 0.4 * std::cos(7 * t), 1.1 * std::sin(t)}});
  }
  return samples;
}

ImuExpectation PicturesOfTenSeconds() {
  ImuExpectation expected;
  expected.from = "imu0/data.csv";
  expected.first_picture_ns = kBegin_ns;
  expected.last_picture_ns = kBegin_ns + 1999 * kInterval_ns;
  expected.rate_hz = 200;
  return expected;
}

TEST(ImuChecksTest, HasNothingToSayOfAGoodImu) {
  SourceFindings findings;
  const auto statistics = MeasureImu(CarriedImu(), PicturesOfTenSeconds(), findings);
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_THAT(findings, IsEmpty());
  EXPECT_NEAR(statistics->rate_hz, 200, 1e-6);
  EXPECT_EQ(statistics->samples, 2000u);
  EXPECT_EQ(DescribeImu(*statistics, "FILE"),
            "200 Hz, 2000 samples from 1403715273.000000000 to 1403715282.995000000 s, from FILE; "
            "no gaps");
}

struct OddImu {
  const char* name;
  std::function<void(ImuSamples&, ImuExpectation&)> make;
  const char* code;  // Empty: refused.
  const char* says;
};

void ScaleForce(ImuSamples& samples, double by) {
  for (ImuSample& sample : samples) sample.specific_force_mps2 *= by;
}

void ScaleTimes(ImuSamples& samples, int64_t by) {
  for (ImuSample& sample : samples) sample.timestamp_ns /= by;
}

class OddImuTest : public ::testing::TestWithParam<OddImu> {};

TEST_P(OddImuTest, IsTold) {
  ImuSamples samples = CarriedImu();
  ImuExpectation expected = PicturesOfTenSeconds();
  GetParam().make(samples, expected);
  SourceFindings findings;
  const auto statistics = MeasureImu(samples, expected, findings);
  if (*GetParam().code == '\0') {
    EXPECT_TRUE(absl::IsInvalidArgument(statistics.status())) << statistics.status();
    EXPECT_THAT(std::string(statistics.status().message()), HasSubstr("imu0/data.csv: "));
    EXPECT_THAT(std::string(statistics.status().message()), HasSubstr(GetParam().says));
    return;
  }
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, GetParam().code);
  EXPECT_EQ(findings[0].level, FindingLevel::kWarning);
  EXPECT_THAT(findings[0].text, HasSubstr("imu0/data.csv: "));
  EXPECT_THAT(findings[0].text, HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, OddImuTest,
    ::testing::Values(
        OddImu{"Milliseconds",
               [](ImuSamples& samples, ImuExpectation&) { ScaleTimes(samples, 1'000'000); }, "",
               "its times are in milliseconds"},
        OddImu{"Microseconds",
               [](ImuSamples& samples, ImuExpectation&) { ScaleTimes(samples, 1'000); }, "",
               "its times are in microseconds"},
        OddImu{"SlowerThanAnImu",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (size_t i = 0; i < samples.size(); ++i) {
                   samples[i].timestamp_ns += static_cast<int64_t>(i) * 4'995'000'000;
                 }
               },
               "", "its times are in another unit"},
        OddImu{"AnotherClock",
               [](ImuSamples&, ImuExpectation& expected) {
                 expected.first_picture_ns = 12'000'000'000;
                 expected.last_picture_ns = 22'000'000'000;
               },
               "",
               "measured from 1403715273.000000000 to 1403715282.995000000 s, the pictures were "
               "taken from 12.000000000 to 22.000000000 s"},
        OddImu{"InG",
               [](ImuSamples& samples, ImuExpectation&) { ScaleForce(samples, 1 / 9.80665); }, "",
               "they are in g. Multiply them by 9.80665"},
        OddImu{"InMg",
               [](ImuSamples& samples, ImuExpectation&) { ScaleForce(samples, 1000 / 9.80665); },
               "", "they are in mg"},
        OddImu{"Counts", [](ImuSamples& samples, ImuExpectation&) { ScaleForce(samples, 800); }, "",
               "they are in another unit"},
        OddImu{"WithoutGravity",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (ImuSample& sample : samples) sample.specific_force_mps2.y() -= 9.7;
               },
               "", "gravity was taken out of them"},
        OddImu{"Exchanged",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (ImuSample& sample : samples) {
                   std::swap(sample.angular_velocity_rps, sample.specific_force_mps2);
                 }
               },
               "", "gyroscope and accelerometer are exchanged"},
        OddImu{"NoGyroscope",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (ImuSample& sample : samples) sample.angular_velocity_rps.setZero();
               },
               "", "the gyroscope measured one and the same in all 2000 samples"},
        OddImu{"DeadAxis",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (ImuSample& sample : samples) sample.angular_velocity_rps.z() = -0.02;
               },
               "imu-axis-constant", "the gyroscope's z is -0.02 in all 2000 samples"},
        OddImu{"OddForce", [](ImuSamples& samples, ImuExpectation&) { ScaleForce(samples, 2); },
               "imu-force-odd", "is gravity in them?"},
        OddImu{"Degrees",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (ImuSample& sample : samples) sample.angular_velocity_rps *= 57.29578;
               },
               "imu-turning-odd", "are these degrees a second?"},
        OddImu{"Gaps",
               [](ImuSamples& samples, ImuExpectation&) {
                 samples.erase(samples.begin() + 400, samples.begin() + 500);
                 samples.erase(samples.begin() + 1000, samples.begin() + 1010);
               },
               "imu-gaps",
               "some 110 samples of the IMU are missing in 2 gaps, the longest of 0.505"},
        OddImu{"BeginsLate",
               [](ImuSamples& samples, ImuExpectation&) {
                 samples.erase(samples.begin(), samples.begin() + 400);
               },
               "imu-covers-part", "begins 2.000 s after the first picture and ends 0.000 s before"},
        OddImu{"EndsEarly", [](ImuSamples& samples, ImuExpectation&) { samples.resize(1500); },
               "imu-covers-part", "ends 2.500 s before the last"},
        OddImu{"Saturated",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (size_t i = 700; i < 720; ++i) samples[i].specific_force_mps2.x() = -19.6;
               },
               "imu-saturated",
               "20 samples of the accelerometer's x axis are at its extreme, -19.6"},
        OddImu{"OtherRate", [](ImuSamples&, ImuExpectation& expected) { expected.rate_hz = 500; },
               "imu-rate-other", "measured 200 times a second, its calibration says 500"},
        OddImu{"ReadTwice",
               [](ImuSamples& samples, ImuExpectation&) {
                 for (size_t i = 1; i < samples.size(); i += 2) {
                   const int64_t time_ns = samples[i].timestamp_ns;
                   samples[i] = samples[i - 1];
                   samples[i].timestamp_ns = time_ns;
                 }
               },
               "imu-values-repeat", "1000 of 2000 samples"}),
    testing::NamedBy(&OddImu::name));

TEST(ImuChecksTest, WhatIsToBeTrustedIsAWarning) {
  ImuSamples samples = CarriedImu();
  ScaleForce(samples, 1 / 9.80665);
  ImuExpectation expected = PicturesOfTenSeconds();
  expected.trust = true;
  SourceFindings findings;
  ASSERT_TRUE(MeasureImu(samples, expected, findings).ok());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, "imu-force-odd");
}

// A drone that races: no units are wrong.
TEST(ImuChecksTest, AFastDroneIsNotRefused) {
  ImuSamples samples = CarriedImu();
  for (size_t i = 0; i < samples.size(); ++i) {
    const double t = 0.005 * static_cast<double>(i);
    samples[i].angular_velocity_rps *= 8;
    samples[i].specific_force_mps2 += Eigen::Vector3d(0, 0, 8 * std::sin(9 * t));
  }
  samples[900].angular_velocity_rps.x() = 19;
  SourceFindings findings;
  const auto statistics = MeasureImu(samples, PicturesOfTenSeconds(), findings);
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_THAT(findings, IsEmpty()) << findings[0].text;
}

TEST(ImuChecksTest, NoSampleWhilePicturesWereTakenIsRefused) {
  ImuSamples samples = CarriedImu();
  ImuExpectation expected = PicturesOfTenSeconds();
  // The pictures fall in a long pause of the IMU.
  for (size_t i = 1000; i < samples.size(); ++i) samples[i].timestamp_ns += 100'000'000'000;
  expected.first_picture_ns = kBegin_ns + 50'000'000'000;
  expected.last_picture_ns = kBegin_ns + 60'000'000'000;
  SourceFindings findings;
  EXPECT_THAT(std::string(MeasureImu(samples, expected, findings).status().message()),
              HasSubstr("no sample of the IMU within 10 s of the pictures"));
}

}  // namespace
}  // namespace corbslam::client_agent
