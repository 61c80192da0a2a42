#include "client_agent/source/source_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(SourceSpecTest, ReadsEveryOption) {
  const absl::StatusOr<SourceSpec> spec = ParseSourceSpec(
      "tum:some/dir/?frames=10:20&stride=3&offset=1&reverse=1&gamma=0.8&noise=4&seed=7");
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(spec->layout, SourceLayout::kTum);
  EXPECT_EQ(spec->directory, "some/dir");
  EXPECT_THAT(SelectFrames(spec->selection, 100), ElementsAre(19, 16, 13, 10));
  EXPECT_EQ(spec->perturbation.gamma, 0.8);
  EXPECT_EQ(spec->perturbation.noise_sigma, 4);
  EXPECT_EQ(spec->perturbation.seed, 7u);
}

TEST(SourceSpecTest, ComesBackAsFormatted) {
  for (const char* text :
       {"kitti:a", "euroc:/b/c?frames=5:", "tum:d?frames=1:2&stride=2&offset=1&reverse=1",
        "kitti:e?gamma=0.8&noise=4&seed=9", "kitti:e?gamma=0.123456789", "kitti:g?truth_frame=town",
        "kitti:f?robot=2/3", "tum:g?frames=10:90&robot=1/2&overlap=5"}) {
    EXPECT_EQ(FormatSourceSpec(*ParseSourceSpec(text)), text);
  }
}

TEST(SourceSpecTest, NamesWhatItDoesNotUnderstand) {
  const std::pair<const char*, const char*> cases[] = {{"somewhere", "not LAYOUT:DIR"},
                                                       {"png:a", "layout 'png'"},
                                                       {"kitti:", "no directory"},
                                                       {"kitti:a?frames=9:3", "frames=9:3"},
                                                       {"kitti:a?frames=9", "frames=9"},
                                                       {"kitti:a?stride=0", "stride=0"},
                                                       {"kitti:a?gamma=dark", "gamma=dark"},
                                                       {"kitti:a?noise=-1", "noise=-1"},
                                                       {"kitti:a?colour=blue", "'colour'"},
                                                       {"kitti:a?reverse=maybe", "reverse=maybe"},
                                                       {"kitti:a?frames=1:2e9", "frames=2e9"},
                                                       {"kitti:a?seed=x", "seed=x"},
                                                       {"kitti:a?robot=3/2", "robot=3/2"},
                                                       {"kitti:a?robot=0/2", "robot=0/2"},
                                                       {"kitti:a?robot=2", "robot"},
                                                       {"kitti:a?phase=0.5", "'phase'"}};
  for (const auto& [text, expected] : cases) {
    const absl::Status status = ParseSourceSpec(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr(expected));
  }
}

TEST(SourceSpecTest, TakesOptionsWithCommas) {
  SourceSpec spec;
  ASSERT_TRUE(ApplyOptions("gamma=0.8,noise=4,reverse", spec).ok());
  EXPECT_TRUE(spec.selection.reverse);
  EXPECT_EQ(spec.perturbation.noise_sigma, 4);
}

TEST(SourceSpecTest, ZeroBytesAreRefused) {
  // The file system would read no further, and find the folder ".".
  const absl::StatusOr<SourceSpec> spec =
      ParseSourceSpec(absl::string_view("tum:.\0frame=A?stride=4", 22));
  EXPECT_EQ(spec.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(spec.status().message()),
              HasSubstr("'tum:.\\000frame=A?stride=4' holds a zero byte at 5"));
}

TEST(TakePartTest, SharesAsThePaperDoes) {
  const auto part = [](size_t robot, size_t robots, size_t overlap, FrameRange all) {
    const FrameRange range = TakePart(all, {robot, robots, overlap});
    return std::pair(range.begin, range.end);
  };
  using Range = std::pair<size_t, size_t>;
  // Two robots have [0, t/2 + d] and [t/2 - d, t].
  EXPECT_EQ(part(1, 2, 20, {0, 4541}), Range(0, 2291));
  EXPECT_EQ(part(2, 2, 20, {0, 4541}), Range(2250, 4541));
  // Three robots have [0, t/3 + d], [t/3 - d, 2t/3 + d] and [2t/3 - d, t].
  EXPECT_EQ(part(1, 3, 10, {0, 2760}), Range(0, 930));
  EXPECT_EQ(part(2, 3, 10, {0, 2760}), Range(910, 1850));
  EXPECT_EQ(part(3, 3, 10, {0, 2760}), Range(1830, 2760));
  // Overlaps end with the sequence; a range that does not begin at 0 is shared as others are.
  EXPECT_EQ(part(2, 2, 1000, {100, 200}), Range(100, 200));
  EXPECT_EQ(part(1, 2, 0, {100, 200}), Range(100, 150));
  EXPECT_EQ(part(1, 1, 20, {5, 9}), Range(5, 9));
  EXPECT_EQ(part(2, 3, 20, {5, 5}), Range(5, 5));
}

TEST(TakePartTest, TogetherAllFramesAreTaken) {
  for (size_t robots = 1; robots <= 9; ++robots) {
    for (size_t count = 1; count <= 40; ++count) {
      size_t reached = 0;
      for (size_t robot = 1; robot <= robots; ++robot) {
        const FrameRange range = TakePart({0, count}, {robot, robots, 0});
        EXPECT_LE(range.begin, reached);
        reached = std::max(reached, range.end);
      }
      EXPECT_EQ(reached, count);
    }
  }
}

TEST(SelectFramesTest, StrideCountsFromTheSequencesStart) {
  FrameSelection odd;
  odd.first = 80;
  odd.last = 86;
  odd.stride = 2;
  odd.offset = 1;
  EXPECT_THAT(SelectFrames(odd, 201), ElementsAre(81, 83, 85));
}

TEST(SelectFramesTest, EndsWithTheSequence) {
  FrameSelection selection;
  selection.first = 3;
  EXPECT_THAT(SelectFrames(selection, 5), ElementsAre(3, 4));
  selection.last = 1000;
  EXPECT_THAT(SelectFrames(selection, 5), ElementsAre(3, 4));
  EXPECT_THAT(SelectFrames(selection, 2), IsEmpty());
}

}  // namespace
}  // namespace corbslam::client_agent
