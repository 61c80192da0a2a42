#include "slam/coding/feature_coding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>

#include "slam/coding/byte_fields.h"
#include "slam/coding/feature_columns.h"
#include "slam/coding/testing/plausible_features.h"
#include "slam/util/checksum.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

constexpr PictureSize kPicture = {1241, 376};
constexpr size_t kLimit = 20'000;

FeatureColumns Plausible(size_t count) {
  return ToColumns(testing::MakePlausibleFeatures(1, count, kPicture));
}

void ExpectPasses(const FeatureColumns& columns, const PictureSize& picture = kPicture) {
  const auto bytes = EncodeFeatures(columns, picture);
  ASSERT_TRUE(bytes.has_value());
  const auto read = DecodeFeatures(*bytes, kLimit);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, columns);
  EXPECT_EQ(CountCodedKeypoints(*bytes), columns.size());
}

TEST(FeatureCodingTest, FeaturesPassUnchanged) {
  for (const size_t count : {10u, 11u, 500u, 2000u}) ExpectPasses(Plausible(count));
}

TEST(FeatureCodingTest, TwoThousandTakeLessThan45Kilobytes) {
  EXPECT_LT(EncodeFeatures(Plausible(2000), kPicture)->size(), 45'000u);
}

// Journals and spools are read for years: whoever changes the bytes makes another version.
TEST(FeatureCodingTest, BytesOfThisVersionStay) {
  ASSERT_EQ(kFeatureCodingVersion, 1);
  const PictureSize picture = {1241, 376};
  const auto crc_of = [&](uint32_t seed, size_t count) {
    const FeatureColumns columns = ToColumns(testing::MakePlausibleFeatures(seed, count, picture));
    return ExtendCrc32c(0, EncodeFeatures(columns, picture).value());
  };
  EXPECT_EQ(crc_of(1, 2001), 0xdff5777cu);
  EXPECT_EQ(crc_of(2, 2002), 0x250abd96u);
}

TEST(FeatureCodingTest, WithoutDisparitiesOrDescriptors) {
  FeatureColumns columns = Plausible(300);
  columns.disparity_px128.clear();
  ExpectPasses(columns);
  columns = Plausible(300);
  columns.descriptors.clear();
  ExpectPasses(columns);
}

TEST(FeatureCodingTest, OfAnyPictureInAnyOrder) {
  FeatureColumns columns = Plausible(300);
  ExpectPasses(columns, {1, 1});
  ExpectPasses(columns, {kMaxCodedSide_px, kMaxCodedSide_px});
  std::mt19937 random(3);
  for (size_t i = 0; i < columns.size(); ++i) {
    std::swap(columns.x_px64[i], columns.x_px64[random() % 300]);
    columns.octaves[i] = static_cast<char>(random());
  }
  ExpectPasses(columns);
}

TEST(FeatureCodingTest, ExtremeNumbersPass) {
  FeatureColumns columns = Plausible(300);
  for (size_t i = 0; i < 300; i += 50) {
    columns.x_px64[i] = std::numeric_limits<int32_t>::max();
    columns.x_px64[i + 1] = std::numeric_limits<int32_t>::min();
    columns.y_px64[i + 1] = std::numeric_limits<int32_t>::max();
    columns.y_px64[i + 2] = std::numeric_limits<int32_t>::min();
    columns.disparity_px128[i] = kMaxDisparity_px128;
    columns.angle_turn14[i] = kTurnSteps - 1;
  }
  ExpectPasses(columns);
}

TEST(FeatureCodingTest, WhatIsBetterKeptAsItIsIsNotCoded) {
  EXPECT_FALSE(EncodeFeatures({}, kPicture).has_value());
  EXPECT_FALSE(EncodeFeatures(Plausible(10), {0, 376}).has_value());
  EXPECT_FALSE(EncodeFeatures(Plausible(10), {1241, kMaxCodedSide_px + 1}).has_value());
  // Bits that are no picture's cost more than themselves.
  FeatureColumns noise = Plausible(100);
  std::mt19937_64 random(1);
  for (Descriptor& descriptor : noise.descriptors) {
    for (uint64_t& word : descriptor.words) word = random();
  }
  EXPECT_FALSE(EncodeFeatures(noise, kPicture).has_value());
  // Equal keypoints code to less than readers accept.
  FeatureColumns alike = Plausible(1);
  for (FeatureColumns one = alike; alike.size() < 2000;) {
    alike.x_px64.push_back(one.x_px64[0]);
    alike.y_px64.push_back(one.y_px64[0]);
    alike.disparity_px128.push_back(one.disparity_px128.empty() ? 0 : one.disparity_px128[0]);
    alike.angle_turn14.push_back(one.angle_turn14[0]);
    alike.octaves.push_back(one.octaves[0]);
  }
  alike.disparity_px128.clear();
  alike.descriptors.clear();
  EXPECT_FALSE(EncodeFeatures(alike, kPicture).has_value());
  FeatureColumns uneven = Plausible(10);
  uneven.octaves.pop_back();
  EXPECT_FALSE(EncodeFeatures(uneven, kPicture).has_value());
}

TEST(FeatureCodingTest, CutShortItIsRefused) {
  const std::string bytes = *EncodeFeatures(Plausible(40), kPicture);
  for (size_t size = 0; size < bytes.size(); ++size) {
    const absl::Status status = DecodeFeatures(bytes.substr(0, size), kLimit).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << size;
  }
}

TEST(FeatureCodingTest, EveryChangedByteIsRefused) {
  const std::string bytes = *EncodeFeatures(Plausible(40), kPicture);
  for (size_t at = 0; at < bytes.size(); ++at) {
    for (const int flip : {1, 0x80}) {
      std::string harmed = bytes;
      harmed[at] = static_cast<char>(harmed[at] ^ flip);
      const auto read = DecodeFeatures(harmed, kLimit);
      EXPECT_TRUE(absl::IsInvalidArgument(read.status()) || *read == Plausible(40)) << at;
    }
  }
}

struct Malformed {
  const char* name;
  std::function<std::string(std::string)> harm;
  const char* says;
};

class MalformedFeaturesTest : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedFeaturesTest, IsRefusedByNameAndLimit) {
  const std::string bytes = *EncodeFeatures(Plausible(100), kPicture);
  const absl::Status status = DecodeFeatures(GetParam().harm(bytes), kLimit).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

// Writes version, flags and the numbers, followed by `rest`.
std::string Header(char version, char flags, uint32_t count, std::string rest) {
  std::string bytes = {version, flags};
  AppendNumber(count, &bytes);
  AppendNumber(1241, &bytes);
  AppendNumber(376, &bytes);
  return bytes + rest;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, MalformedFeaturesTest,
    ::testing::Values(
        Malformed{"Empty", [](std::string) { return std::string(); }, "cut short, 0 bytes"},
        Malformed{"Version",
                  [](std::string bytes) {
                    bytes[0] = 2;
                    return bytes;
                  },
                  "version is 2, this program reads 1"},
        Malformed{"Flags",
                  [](std::string bytes) {
                    bytes[1] = 4;
                    return bytes;
                  },
                  "flags are 4, must be 0 to 3"},
        Malformed{"TooMany",
                  [](std::string) { return Header(1, 3, 20'001, std::string(100'000, 'x')); },
                  "number of keypoints is 20001, the limit is 20000"},
        Malformed{"Bomb", [](std::string) { return Header(1, 3, 20'000, std::string(300, 'x')); },
                  "bytes for 20000 keypoints, must be 4 each"},
        Malformed{"None", [](std::string) { return Header(1, 3, 0, std::string(300, 'x')); },
                  "0 keypoints of a picture of 1241x376"},
        Malformed{"LongNumber",
                  [](std::string) { return std::string("\1\3") + std::string(10, '\xff'); },
                  "cut short in its header"},
        Malformed{"StreamTooLong",
                  [](std::string) {
                    std::string rest;
                    for (int i = 0; i < 5; ++i) AppendNumber(1u << 31, &rest);
                    return Header(1, 3, 10, rest + std::string(100, 'x'));
                  },
                  "a stream is longer than all there is"},
        Malformed{"More", [](std::string bytes) { return bytes + "x"; },
                  "the checksum differs, or more follows it"},
        Malformed{"Checksum",
                  [](std::string bytes) {
                    bytes.back() = static_cast<char>(bytes.back() ^ 1);
                    return bytes;
                  },
                  "the checksum differs"}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace corbslam
