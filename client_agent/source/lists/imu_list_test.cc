#include "client_agent/source/lists/imu_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kTwoSamples[] =
    "1403715273262142976,-0.0020943951023931952,0.017,0.077,9.0874956666666655,0.13,-3.69\n"
    "1403715273267142912,-0.0013962634015954637,0.019,0.078,9.0793234583333327,0.12,-3.69\n";

std::string WriteList(const std::string& text) {
  const std::string path = ::testing::TempDir() + "/imu_list.csv";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

absl::StatusOr<ImuSamples> ReadList(const std::string& text) {
  SourceRemarks remarks;
  return ReadImuList(WriteList(text), remarks);
}

std::vector<int64_t> StampsOf(const ImuSamples& samples) {
  std::vector<int64_t> stamps;
  for (const ImuSample& sample : samples) stamps.push_back(sample.timestamp_ns);
  return stamps;
}

ImuSamples SamplesAt(const std::vector<int64_t>& stamps_ns) {
  ImuSamples samples;
  for (const int64_t stamp_ns : stamps_ns) {
    const double value = 1e-9 * static_cast<double>(stamp_ns);
    samples.push_back({stamp_ns, {value, 0, 0}, {0, 0, 9.8}});
  }
  return samples;
}

TEST(ImuListTest, ReadsEurocsFormHoweverItIsWritten) {
  const std::string two = kTwoSamples;
  std::string with_blanks;
  std::string with_cr;
  for (const char c : two) {
    with_blanks += c == ',' ? std::string(", ") : std::string(1, c);
    with_cr += c == '\n' ? std::string("\r\n") : std::string(1, c);
  }
  std::string with_semicolons = two;
  std::string with_tabs = two;
  for (char& c : with_semicolons) c = c == ',' ? ';' : c;
  for (char& c : with_tabs) c = c == ',' ? '\t' : c;
  const std::string headings = "timestamp,w_x,w_y,w_z,a_x,a_y,a_z\n";
  for (const std::string& text :
       {two, absl::StrCat(kImuHeading, "\n", two), headings + two, with_blanks, with_cr,
        with_semicolons, with_tabs, "\xef\xbb\xbf" + headings + two,
        "# gyroscope behind accelerometer, in deg: no\n" + two}) {
    const auto samples = ReadList(text);
    ASSERT_TRUE(samples.ok()) << samples.status() << "\n" << text;
    EXPECT_THAT(StampsOf(*samples), ElementsAre(1403715273262142976, 1403715273267142912));
    EXPECT_EQ((*samples)[0].angular_velocity_rps,
              Eigen::Vector3d(-0.0020943951023931952, 0.017, 0.077));
    EXPECT_EQ((*samples)[1].specific_force_mps2, Eigen::Vector3d(9.0793234583333327, 0.12, -3.69));
  }
}

TEST(ImuListTest, WritesWhatItReads) {
  const auto samples = ReadList(kTwoSamples);
  ASSERT_TRUE(samples.ok()) << samples.status();
  const auto again = ReadList(absl::StrCat(kImuHeading, "\n", FormatImuLine((*samples)[0]), "\n",
                                           FormatImuLine((*samples)[1]), "\n"));
  ASSERT_TRUE(again.ok()) << again.status();
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*again)[i].timestamp_ns, (*samples)[i].timestamp_ns);
    EXPECT_EQ((*again)[i].angular_velocity_rps, (*samples)[i].angular_velocity_rps);
    EXPECT_EQ((*again)[i].specific_force_mps2, (*samples)[i].specific_force_mps2);
  }
}

struct BadImuList {
  const char* name;
  std::string text;
  const char* says;
};

class BadImuListTest : public ::testing::TestWithParam<BadImuList> {};

TEST_P(BadImuListTest, IsRefusedWithItsLine) {
  const absl::Status status = ReadList(GetParam().text).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("imu_list.csv"));
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadImuListTest,
    ::testing::Values(
        BadImuList{"ColumnsMissing", "1000000,0.1,0.1,0.1\n", ":1: 4 fields instead of 7"},
        BadImuList{"ColumnsMore", absl::StrCat(kTwoSamples, "1403715273272142912,0,0,0,0,0,9,25\n"),
                   ":3: 8 fields instead of 7"},
        BadImuList{"NotANumber", absl::StrCat(kTwoSamples, "1403715273272142912,nan,0,0,0,0,9\n"),
                   ":3: field 2 is no number: nan"},
        BadImuList{"Infinite", "5000000,0,0,0,0,0,inf\n", ":1: field 7 is no number: inf"},
        BadImuList{"Empty", "", "lists 0 samples"},
        BadImuList{"HeadingAlone", absl::StrCat(kImuHeading, "\n"), "lists 0 samples"},
        BadImuList{"Seconds", "1403715273.262142976,0,0,0,0,0,9.8\n", "Is it in seconds?"},
        BadImuList{"Rounded", "1.4037152732e+18,0,0,0,0,0,9.8\n", "no time in whole nanoseconds"},
        BadImuList{"Negative", "-5,0,0,0,0,0,9.8\n", "the time -5 is negative"},
        BadImuList{
            "Degrees",
            absl::StrCat("#t [ns],w_x [deg/s],w_y [deg/s],w_z [deg/s],a_x,a_y,a_z\n", kTwoSamples),
            ":1: the heading says degrees"},
        BadImuList{"AccelerationsFirst",
                   absl::StrCat("time,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z\n", kTwoSamples),
                   "put the gyroscope's three fields first"},
        BadImuList{"TwoRecordings",
                   absl::StrCat(kTwoSamples, "1403715200000000000,0,0,0,0,0,9.8\n"),
                   "jumps back from 1403715273267142912 to 1403715200000000000 ns"},
        BadImuList{"OneTime", "5,0,0,0,0,0,9.8\n5,0,0,0,0,0,9.9\n5,0,0,0,0,0,9.9\n",
                   "2 of 3 samples of the IMU have the time of another"},
        BadImuList{"Falling", "9,0,0,0,0,0,9.8\n8,0,0,0,0,0,9.9\n7,0,0,0,0,0,9.9\n",
                   "2 of 3 samples of the IMU are out of order"}),
    testing::NamedBy(&BadImuList::name));

TEST(ImuListTest, AFileThatIsNotThereIsNotFound) {
  SourceRemarks remarks;
  EXPECT_TRUE(absl::IsNotFound(ReadImuList("/nowhere/imu.csv", remarks).status()));
}

TEST(ImuListTest, PutsAFewInOrderAndTakesEachTimeOnce) {
  std::vector<int64_t> stamps;
  for (int64_t i = 0; i < 40; ++i) stamps.push_back(5'000'000 * i);
  std::vector<int64_t> odd = stamps;
  std::swap(odd[10], odd[11]);
  odd.insert(odd.begin() + 20, odd[20]);
  ImuSamples samples = SamplesAt(odd);
  SourceFindings findings;
  ASSERT_TRUE(PutInOrder("imu.csv", samples, findings).ok());
  EXPECT_EQ(StampsOf(samples), stamps);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].code, "imu-out-of-order");
  EXPECT_THAT(findings[0].text, HasSubstr("imu.csv: 1 of 41"));
  EXPECT_EQ(findings[1].code, "imu-times-repeat");
  EXPECT_THAT(findings[1].text, HasSubstr("; 0 of them with other values"));
}

TEST(ImuBetweenTest, GivesEachSampleOnceUpToTheFirstBehindThePicture) {
  const ImuSamples samples = SamplesAt({0, 5'000'000, 10'000'000, 15'000'000, 20'000'000});
  const auto between = [&](int64_t after_ns, int64_t until_ns) {
    return StampsOf(ImuBetween(samples, after_ns, until_ns));
  };
  EXPECT_THAT(between(-1, 7'000'000), ElementsAre(0, 5'000'000, 10'000'000));
  // The next picture lies before the sample that the one before has got already.
  EXPECT_THAT(between(10'000'000, 9'000'000), IsEmpty());
  EXPECT_THAT(between(10'000'000, 10'000'000), IsEmpty());
  EXPECT_THAT(between(10'000'000, 15'000'000), ElementsAre(15'000'000));
  EXPECT_THAT(between(15'000'000, 40'000'000), ElementsAre(20'000'000));
  EXPECT_THAT(between(20'000'000, 40'000'000), IsEmpty());
  EXPECT_THAT(StampsOf(ImuBetween({}, 0, 1)), IsEmpty());
}

TEST(ImuBetweenTest, WhatLiesBehindAGapIsALaterPictures) {
  const ImuSamples samples = SamplesAt({0, 5'000'000, 900'000'000, 905'000'000});
  EXPECT_THAT(StampsOf(ImuBetween(samples, -1, 50'000'000)), ElementsAre(0, 5'000'000));
  EXPECT_THAT(StampsOf(ImuBetween(samples, 5'000'000, 850'000'000)), ElementsAre(900'000'000));
}

}  // namespace
}  // namespace corbslam::client_agent
