#include "services/tool/report/html/report_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/sha.h>

#include <algorithm>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kHostile[] = "</script><img src=x onerror=alert(1)>\"'{{data}}";

ReportDetail MakeDetail(const std::vector<std::string>& names) {
  ReportDetail detail;
  for (size_t k = 0; k < names.size(); ++k) {
    ReportDetail::Robot& robot = detail.robots.emplace_back();
    MapPicture::Robot& mapped = detail.map.robots.emplace_back();
    robot.name = mapped.name = names[k];
    mapped.is_own = k == 0;
    robot.tracked = {{0, 4}};
    for (int i = 0; i < 40; ++i) {
      Rigid3d pose;
      pose.translation = {1.0 * static_cast<double>(k), 0, 1.0 * i};
      mapped.keyframes.push_back(pose);
      robot.errors.push_back({int64_t{100'000'000} * i, pose.translation, pose, 0.01 * i});
      for (int n = 0; n < 5; ++n) {
        detail.map.points.push_back(pose.translation + Eigen::Vector3d(n, -1, 2));
      }
    }
    robot.by_length = {{100, {1.5, 0.1, 3}}};
  }
  return detail;
}

RunReport MakeReport(const std::vector<std::string>& names) {
  RunReport report;
  report.mission = "lab";
  report.pace = "max";
  for (const std::string& name : names) {
    report.robots.emplace_back().name = name;
    report.robots.back().source = "sim:city";
  }
  report.merge_ms = {12};
  report.global_ba_ms.push_back({64, 10000, 12, 800});
  report.servers["map_store"] = {100, 3};
  report.command = "corbslam run";
  return report;
}

// Returns what is wrong with the nesting of elements; an empty text if nothing is.
std::string FindFault(absl::string_view html) {
  const std::set<std::string> empty_elements = {"meta", "input", "path", "rect"};
  std::vector<std::string> open;
  for (size_t at = html.find('<'); at != html.npos; at = html.find('<', at + 1)) {
    if (absl::StartsWith(html.substr(at), "<!DOCTYPE")) continue;
    const bool closes = html[at + 1] == '/';
    size_t end = at + (closes ? 2 : 1);
    const size_t begin = end;
    while (end < html.size() && absl::ascii_isalnum(static_cast<unsigned char>(html[end]))) ++end;
    const std::string name(html.substr(begin, end - begin));
    if (name.empty()) return absl::StrCat("a < at ", at, ": ", html.substr(at, 40));
    if (closes) {
      if (open.empty() || open.back() != name) return absl::StrCat("</", name, "> at ", at);
      open.pop_back();
    } else if (!empty_elements.contains(name)) {
      open.push_back(name);
      if (name == "script" || name == "style") at = html.find(absl::StrCat("</", name), at) - 1;
    }
  }
  return open.empty() ? "" : absl::StrCat("<", open.back(), "> stays open");
}

TEST(ToHtmlTest, ShowsAllRobotsAndNestsRightly) {
  const std::vector<std::string> names = {"alpha", "bravo", "charlie"};
  const std::string html = ToHtml(MakeReport(names), MakeDetail(names));
  EXPECT_EQ(FindFault(html), "");
  for (const std::string& name : names) {
    EXPECT_THAT(html, HasSubstr(absl::StrCat("<th scope=\"row\">", name, "</th>")));
  }
  EXPECT_THAT(html, Not(HasSubstr("{{")));
  EXPECT_THAT(html, Not(HasSubstr("class=\"warnings\"")));
}

TEST(ToHtmlTest, LoadsNothing) {
  const std::string html = ToHtml(MakeReport({"alpha"}), MakeDetail({"alpha"}));
  // The only addresses are names of namespaces, which nobody fetches.
  for (const char* word :
       {"src=", "href=\"h", "href=\"/", "@import", "url(", "https:", "fetch(", "style=\""}) {
    EXPECT_THAT(html, Not(HasSubstr(word)));
  }
  EXPECT_THAT(html, HasSubstr("content=\"default-src 'none'; base-uri 'none'; form-action 'none'; "
                              "style-src 'sha256-"));
  EXPECT_THAT(html, Not(HasSubstr("unsafe-inline")));
}

TEST(ToHtmlTest, EscapesWhatOthersNamed) {
  RunReport report = MakeReport({kHostile, "bravo"});
  report.mission = kHostile;
  report.command = kHostile;
  report.version = kHostile;
  report.robots[0].source = kHostile;
  report.warnings.push_back({kHostile, kHostile, kHostile});
  report.servers[kHostile] = {1, 1};
  const std::string html = ToHtml(report, MakeDetail({kHostile, "bravo"}));
  EXPECT_EQ(FindFault(html), "");
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, HasSubstr("class=\"warnings\""));
}

TEST(ToHtmlTest, TakesARunThatBroughtNothing) {
  const std::string html = ToHtml(RunReport(), ReportDetail());
  EXPECT_EQ(FindFault(html), "");
  EXPECT_THAT(html, HasSubstr("there is no map"));
  EXPECT_THAT(html, HasSubstr("There is no ground truth"));
}

// Makes a report whose robots played alone, too.
RunReport MakeCompany(const std::vector<std::string>& names) {
  RunReport report = MakeReport(names);
  report.company.emplace();
  for (RobotReport& robot : report.robots) {
    robot.ate_m = 0.0333;
    robot.ate_global_m = 0.0125;
    robot.points_matched_percent = 40;
    report.company->alone.push_back(robot);
    report.company->alone.back().ate_m = 0.0444;
    report.company->alone.back().ate_global_m = 0.05;
  }
  return report;
}

// Adds the map of `detail` as what each robot holds.
void AddHeld(ReportDetail& detail) {
  for (const ReportDetail::Robot& robot : detail.robots) {
    detail.held.push_back({robot.name, detail.map, detail.map});
  }
}

// Returns what stands between `begin` and the next quotation mark, of each place where `begin` is.
std::vector<std::string> QuotedBehind(const std::string& html, const std::string& begin) {
  std::vector<std::string> found;
  for (size_t at = html.find(begin); at != std::string::npos; at = html.find(begin, at + 1)) {
    const size_t from = at + begin.size();
    found.push_back(html.substr(from, html.find('"', from) - from));
  }
  return found;
}

TEST(ToHtmlTest, ContentsLeadToEachPartOfThePage) {
  const std::vector<std::string> names = {"alpha"};
  const std::string html = ToHtml(MakeReport(names), MakeDetail(names));
  std::vector<std::string> linked = QuotedBehind(html, "<a href=\"#");
  EXPECT_EQ(QuotedBehind(html, "href=\"").size(), linked.size()) << "the page leads nowhere else";
  std::vector<std::string> parts = QuotedBehind(html, "<h2 id=\"");
  EXPECT_GE(linked.size(), 5u);
  std::sort(linked.begin(), linked.end());
  std::sort(parts.begin(), parts.end());
  EXPECT_EQ(linked, parts);
  EXPECT_LT(html.find("id=\"h-map\""), html.find("id=\"h-accuracy\""));
}

TEST(ToHtmlTest, ShowsWhatCompanyGave) {
  const std::vector<std::string> names = {"alpha", kHostile};
  const std::string html = ToHtml(MakeCompany(names), MakeDetail(names));
  EXPECT_EQ(FindFault(html), "");
  EXPECT_THAT(html, HasSubstr("<h2 id=\"h-company\">What company gave</h2>"));
  EXPECT_THAT(html, HasSubstr("alpha: 0.0125 m in the global frame with company, 0.0500 m alone"));
  const size_t figure = html.find("Absolute error in the global frame, with");
  const std::string plot = html.substr(figure, html.find("</svg>", figure) - figure);
  EXPECT_THAT(plot,
              AllOf(HasSubstr(">0.0125<"), HasSubstr(">0.0500<"), Not(HasSubstr(">0.0333<"))));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(ToHtml(MakeReport(names), MakeDetail(names)), Not(HasSubstr("h-company")));
}

TEST(ToHtmlTest, ShowsWhatEachRobotHolds) {
  const std::vector<std::string> names = {"alpha", kHostile};
  ReportDetail detail = MakeDetail(names);
  EXPECT_THAT(ToHtml(MakeReport(names), detail), Not(HasSubstr("h-held")));
  AddHeld(detail);
  detail.held[1].nearer.reset();
  const std::string html = ToHtml(MakeReport(names), detail);
  EXPECT_EQ(FindFault(html), "");
  EXPECT_THAT(html, HasSubstr("The map that alpha holds"));
  EXPECT_THAT(html, HasSubstr("40 keyframes of its own (green) and 40 of others (blue)"));
  EXPECT_THAT(html, HasSubstr("The same, nearer: alpha among others"));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
}

TEST(ToHtmlTest, BoundsWhatRobotsHold) {
  std::vector<std::string> names;
  for (int i = 0; i < 20; ++i) names.push_back(absl::StrCat("robot", i));
  ReportDetail detail = MakeDetail(names);
  for (int i = 0; i < 100'000; ++i) detail.map.points.push_back({0.001 * i, 0, 5});
  const size_t without = ToHtml(MakeReport(names), detail).size();
  AddHeld(detail);
  const std::string html = ToHtml(MakeReport(names), detail);
  EXPECT_THAT(html, HasSubstr("The map that robot7 holds"));
  EXPECT_THAT(html, Not(HasSubstr("The map that robot8 holds")));
  EXPECT_LT(html.size(), without + 4'000'000);
  // What is left out for that is said.
  EXPECT_THAT(html, HasSubstr(" of 104000)"));
}

// Returns the data of the first robot's curve of errors over time.
std::string ErrorCurveOf(const std::string& html) {
  const size_t look = html.find("stroke=\"var(--series-1)\" stroke-width=\"1.8\"");
  if (look == std::string::npos) return "";
  const size_t begin = html.rfind("<path d=\"", look) + 9;
  return html.substr(begin, html.find('"', begin) - begin);
}

TEST(ToHtmlTest, ASlowCamerasErrorsAreOneCurve) {
  ReportDetail detail = MakeDetail({"alpha"});
  for (PoseError& error : detail.robots[0].errors) error.timestamp_ns *= 20;  // Two seconds apart.
  const std::string curve = ErrorCurveOf(ToHtml(MakeReport({"alpha"}), detail));
  EXPECT_EQ(std::count(curve.begin(), curve.end(), 'M'), 1) << curve;
  // Ten frames that were lost are a gap.
  auto& errors = detail.robots[0].errors;
  errors.erase(errors.begin() + 10, errors.begin() + 20);
  const std::string broken = ErrorCurveOf(ToHtml(MakeReport({"alpha"}), detail));
  EXPECT_EQ(std::count(broken.begin(), broken.end(), 'M'), 2) << broken;
}

// The truth begins twenty seconds behind the robot.
TEST(ToHtmlTest, ErrorsStandWhereTheyWere) {
  ReportDetail detail = MakeDetail({"alpha"});
  detail.robots[0].begin_ns = -20'000'000'000;
  const std::string html = ToHtml(MakeReport({"alpha"}), detail);
  EXPECT_THAT(html, HasSubstr(">23</text>"));
  EXPECT_THAT(html, HasSubstr("since the robot&#39;s first tracked frame (s)"));
}

// Two worlds, say: where one would lie in the other means nothing.
TEST(ToHtmlTest, ARobotOutsideTheGlobalFrameHasAPictureOfItsOwn) {
  const std::vector<std::string> names = {"alpha", "bravo", kHostile};
  ReportDetail detail = MakeDetail(names);
  detail.robots[0].errors_are_global = detail.robots[1].errors_are_global = true;
  detail.map.note = absl::StrCat("not drawn: ", kHostile);
  const std::string html = ToHtml(MakeReport(names), detail);
  EXPECT_EQ(FindFault(html), "");
  EXPECT_THAT(html, HasSubstr("<figcaption>Trajectories from above, by error</figcaption>"));
  EXPECT_THAT(html, HasSubstr("by error: &lt;/script&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("by error: bravo")));
  EXPECT_THAT(html, HasSubstr("<p class=\"warnings\">not drawn: &lt;/script&gt;"));
}

TEST(ToHtmlTest, NoNameOfABarIsCutOff) {
  const std::string html = ToHtml(MakeReport({"alpha"}), MakeDetail({"alpha"}));
  EXPECT_THAT(html, HasSubstr(">adjustment 1</text>"));
  EXPECT_THAT(html, HasSubstr(">800, 64 keyframes</text>"));
}

TEST(ToHtmlTest, RobotsHaveTheColoursOfTheViewersPage) {
  const std::vector<std::string> names = {"robot7", "bravo"};
  const std::string html = ToHtml(MakeReport(names), MakeDetail(names));
  const std::string look = " stroke-width=\"1.8\"";
  EXPECT_THAT(html, HasSubstr(absl::StrCat("stroke=\"var(--series-8)\"", look)));
  EXPECT_THAT(html, HasSubstr(absl::StrCat("stroke=\"var(--series-2)\"", look)));
  EXPECT_THAT(html, HasSubstr("--series-8: #5a5a5a;"));
  EXPECT_THAT(html, HasSubstr("--series-8: #c8c8c8;"));
}

TEST(ToHtmlTest, ShowsTheMapInTheViewersPage) {
  ReportDetail detail = MakeDetail({"alpha"});
  detail.recorded = {.mission = kHostile,
                     .map = {"one", "two"},
                     .has_past = true,
                     .pulse = "pulse",
                     .overlaps = {"overlap"}};
  detail.map.truth = {{{0, 0, 0.12345}, {1, 2, 3}}};
  const ViewerPage viewer{"if (1 < 2 && 3 > 2) alert(\"{{data}}\");", "p { margin: 0 }"};
  const std::string html = ToHtml(MakeReport({"alpha"}), detail, viewer);
  EXPECT_EQ(FindFault(html), "");
  EXPECT_THAT(html, HasSubstr("sandbox=\"allow-scripts\" srcdoc=\"&lt;!doctype html&gt;"));
  EXPECT_THAT(html, HasSubstr("if (1 &lt; 2 &amp;&amp; 3 &gt; 2) alert(&quot;{{data}}&quot;);"));
  EXPECT_THAT(html, HasSubstr("\\u003c/script&gt;\\u003cimg"));
  EXPECT_THAT(html, HasSubstr("&quot;map&quot;:[&quot;b25l&quot;,&quot;dHdv&quot;],"
                              "&quot;hasPoints&quot;:false,&quot;hasPast&quot;:true"));
  EXPECT_THAT(html, HasSubstr("&quot;truth&quot;:[[0.0,0.0,0.123,1.0,2.0,3.0]]"));
  EXPECT_THAT(html, HasSubstr("<figure class=\"paper\">"));
  EXPECT_THAT(html, HasSubstr("; script-src 'sha256-"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  // Without the page, or without a recording, the picture from above is all there is.
  EXPECT_THAT(ToHtml(MakeReport({"alpha"}), detail), Not(HasSubstr("<iframe")));
  detail.recorded.map.clear();
  EXPECT_THAT(ToHtml(MakeReport({"alpha"}), detail, viewer), Not(HasSubstr("<iframe")));
}

// Returns what a browser takes from the value of a quoted attribute.
std::string Unquote(const std::string& value) {
  return absl::StrReplaceAll(value,
                             {{"&amp;", "&"}, {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}});
}

// Returns the text between `begin` and the next `end`.
std::string Between(const std::string& text, const std::string& begin, const std::string& end) {
  const size_t from = text.find(begin);
  if (from == std::string::npos) return "";
  const size_t behind = from + begin.size();
  return text.substr(behind, text.find(end, behind) - behind);
}

std::string Sha256Base64(const std::string& text) {
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest);
  return absl::Base64Escape(
      absl::string_view(reinterpret_cast<const char*>(digest), sizeof(digest)));
}

// The frame's script and style must arrive byte for byte, whatever is in them: numbers of colours,
// quotation marks, and characters that a name of a robot may not have.
TEST(ToHtmlTest, ThePolicyAllowsTheFramesScriptAndStyle) {
  ReportDetail detail = MakeDetail({"alpha"});
  detail.recorded = {.mission = kHostile, .map = {"one"}, .pulse = "pulse", .overlaps = {}};
  const ViewerPage viewer{
      "const a = '#fff', b = \"&quot;\", c = `\x7f\xc2\x85\xe2\x80\xae${1 < 2}`;\n",
      "p::before { content: '\xe2\x80\xba \"&amp;\" #'; color: #123 }\n"};
  const std::string html = ToHtml(MakeReport({"alpha"}), detail, viewer);
  const std::string document = Unquote(Between(html, "srcdoc=\"", "\""));
  const std::string script = Between(document, "<script type=\"module\">", "</script>");
  const std::string style = Between(document, "<style>", "</style>");
  EXPECT_EQ(script, viewer.script);
  EXPECT_EQ(style, viewer.style);
  const std::string policy =
      Between(html, "http-equiv=\"Content-Security-Policy\" content=\"", "\"");
  EXPECT_THAT(policy, HasSubstr(absl::StrCat("; script-src 'sha256-", Sha256Base64(script), "'")));
  EXPECT_THAT(policy, HasSubstr(absl::StrCat(" 'sha256-", Sha256Base64(style), "';")));
  EXPECT_THAT(policy, Not(HasSubstr("unsafe")));
}

}  // namespace
}  // namespace corbslam::services
