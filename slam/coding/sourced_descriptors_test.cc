#include "slam/coding/sourced_descriptors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slam/coding/testing/plausible_features.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using Sources = std::vector<std::span<const Descriptor>>;

class SourcedDescriptorsTest : public ::testing::Test {
 protected:
  // The descriptors are copies from two keyframes in no order, and some that are none.
  void SetUp() override {
    for (size_t i = 0; i < 200; ++i) {
      const bool copies = i % 5 != 0;
      const std::vector<Descriptor>& source = i % 3 == 0 ? first_ : second_;
      descriptors_.push_back(copies ? source[i * 7 % source.size()] : others_[i]);
      sources_.push_back(i % 11 == 0 ? std::span<const Descriptor>()
                                     : std::span<const Descriptor>(source));
    }
  }

  const std::vector<Descriptor> first_ =
      testing::MakePlausibleFeatures(1, 300, {640, 480}).descriptors;
  const std::vector<Descriptor> second_ =
      testing::MakePlausibleFeatures(2, 500, {640, 480}).descriptors;
  const std::vector<Descriptor> others_ =
      testing::MakePlausibleFeatures(3, 200, {640, 480}).descriptors;
  std::vector<Descriptor> descriptors_;
  Sources sources_;
};

TEST_F(SourcedDescriptorsTest, PassUnchanged) {
  const auto read = DecodeSourced(EncodeSourced(descriptors_, sources_), sources_);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, descriptors_);
  const auto none = DecodeSourced(EncodeSourced({}, {}), {});
  ASSERT_TRUE(none.ok()) << none.status();
  EXPECT_TRUE(none->empty());
}

TEST_F(SourcedDescriptorsTest, CopiesAreNearlyFree) {
  const Sources sources(300, first_);
  EXPECT_LT(EncodeSourced(first_, sources).size(), 80u);
}

TEST_F(SourcedDescriptorsTest, AnotherSourceIsRefused) {
  const std::string bytes = EncodeSourced(descriptors_, sources_);
  Sources others = sources_;
  others[1] = first_;  // It was the second keyframe.
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeSourced(bytes, others).status()));
  others[1] = {};
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeSourced(bytes, others).status()));
  others = sources_;
  others.pop_back();
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeSourced(bytes, others).status()));
}

TEST_F(SourcedDescriptorsTest, ACopyOfWhatIsNotThereIsRefusedByName) {
  // The descriptor is a copy of the last of 300.
  const std::string bytes =
      EncodeSourced(std::vector<Descriptor>{first_[299]}, Sources{std::span(first_)});
  const absl::Status status =
      DecodeSourced(bytes, Sources{std::span(first_).subspan(0, 299)}).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("descriptor 0 is a copy of none of the 299"));
}

TEST_F(SourcedDescriptorsTest, CutShortOrChangedItIsRefused) {
  const std::string bytes = EncodeSourced(descriptors_, sources_);
  for (size_t at = 0; at < bytes.size(); ++at) {
    EXPECT_TRUE(absl::IsInvalidArgument(DecodeSourced(bytes.substr(0, at), sources_).status()));
    std::string harmed = bytes;
    harmed[at] = static_cast<char>(harmed[at] ^ 0x10);
    const auto read = DecodeSourced(harmed, sources_);
    EXPECT_TRUE(absl::IsInvalidArgument(read.status()) || *read == descriptors_) << at;
  }
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeSourced(bytes + "x", sources_).status()));
}

TEST_F(SourcedDescriptorsTest, AnotherVersionIsNamed) {
  std::string bytes = EncodeSourced(descriptors_, sources_);
  bytes[0] = 9;
  const absl::Status status = DecodeSourced(bytes, sources_).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("version is 9, this program reads 1"));
}

}  // namespace
}  // namespace corbslam
