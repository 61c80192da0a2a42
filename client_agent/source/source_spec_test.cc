#include "client_agent/source/source_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam {
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
        "kitti:e?gamma=0.8&noise=4&seed=9"}) {
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
                                                       {"kitti:a?seed=x", "seed=x"}};
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
}  // namespace corbslam
