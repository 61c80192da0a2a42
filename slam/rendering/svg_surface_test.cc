#include "slam/rendering/svg_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "slam/rendering/svg_text.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(EscapeMarkupTest, LeavesNothingThatMeansSomething) {
  EXPECT_EQ(EscapeMarkup("</text><script>alert('a' & \"b\")</script>"),
            "&lt;/text&gt;&lt;script&gt;alert(&#39;a&#39; &amp; &quot;b&quot;)&lt;/script&gt;");
  EXPECT_EQ(EscapeMarkup("robot-1 \xC3\xA4 \xF0\x9F\xA4\x96"), "robot-1 \xC3\xA4 \xF0\x9F\xA4\x96");
}

TEST(EscapeMarkupTest, ReplacesWhatXmlForbids) {
  const std::string replacement = "\xEF\xBF\xBD";
  EXPECT_EQ(EscapeMarkup(std::string("a\0b", 3)), "a" + replacement + "b");
  EXPECT_EQ(EscapeMarkup("\x1B[31m"), replacement + "[31m");
  EXPECT_EQ(EscapeMarkup("\xFF"), replacement);
  EXPECT_EQ(EscapeMarkup("\xC3"), replacement) << "a character that is cut off";
  EXPECT_EQ(EscapeMarkup("\xE0\x80\xBC"), replacement) << "'<' written too long";
  EXPECT_EQ(EscapeMarkup("\xED\xA0\x80"), replacement) << "half of a pair";
  EXPECT_EQ(EscapeMarkup("\xE2\x80\xAE"), replacement) << "turns what follows around";
}

TEST(ShortenTest, CountsCharacters) {
  EXPECT_EQ(Shorten("alpha", 5), "alpha");
  EXPECT_EQ(Shorten("\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4", 3), "\xC3\xA4\xC3\xA4\xE2\x80\xA6");
}

TEST(FormatShortTest, HasNoZerosToSpare) {
  EXPECT_EQ(FormatShort(1.50, 2), "1.5");
  EXPECT_EQ(FormatShort(-0.001, 2), "0");
  EXPECT_EQ(FormatShort(100, 0), "100");
  EXPECT_EQ(FormatShort(kNaN, 2), "0");
}

TEST(SvgSurfaceTest, StandsAloneOnWhite) {
  SvgSurface surface(100, 50, SvgStyle::kAlone);
  surface.Line({0, 0}, {10.25, 3}, kOwn, 2);
  const std::string svg = surface.Finish("a <b>");
  EXPECT_THAT(svg, StartsWith("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100\""));
  EXPECT_THAT(svg, HasSubstr("<title>a &lt;b&gt;</title>"));
  EXPECT_THAT(svg, HasSubstr("fill=\"#ffffff\""));
  EXPECT_THAT(svg, HasSubstr("stroke=\"#0a8f2f\""));
  EXPECT_THAT(svg, Not(HasSubstr("var(")));
}

TEST(SvgSurfaceTest, TakesThePagesColours) {
  SvgSurface surface(100, 50, SvgStyle::kInAPage);
  surface.Text("x", {1, 2}, 10, kInk);
  surface.Discs({{1, 2}, {3, 4}}, 1.5, kOthers);
  const std::string svg = surface.Finish("\"quoted\"");
  EXPECT_THAT(svg, HasSubstr("aria-label=\"&quot;quoted&quot;\""));
  EXPECT_THAT(svg, HasSubstr("fill=\"var(--ink)\""));
  EXPECT_THAT(svg, HasSubstr("<path d=\"M1 2h0M3 4h0\" fill=\"none\" stroke=\"var(--others)\""));
  EXPECT_THAT(svg, Not(HasSubstr("style=")));
}

TEST(SvgSurfaceTest, LeavesOutWhatIsNotFinite) {
  SvgSurface surface(100, 50, SvgStyle::kAlone);
  surface.Line({0, kNaN}, {1, 1}, kInk, 1);
  surface.FilledPolygon({{0, 0}, {1e300, 0}, {1, 1}}, kInk, kInk);
  surface.Discs({{kNaN, 0}}, 1, kInk);
  surface.Text("x", {kNaN, 0}, 10, kInk);
  EXPECT_THAT(surface.Finish(""), Not(HasSubstr("<path")));
  surface.Path({{0, 0}, {1, 1}, {kNaN, 0}, {2, 2}, {3, 3}}, kInk, 1);
  EXPECT_THAT(surface.Finish(""), HasSubstr("d=\"M0 0L1 1M2 2L3 3\""));
}

}  // namespace
}  // namespace corbslam
