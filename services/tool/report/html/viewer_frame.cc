#include "services/tool/report/html/viewer_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostPathPoints = 4'000;

// Returns an empty text for a file that is not there.
std::string ReadText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// Returns the texts of messages, each in base64.
Json Encode(const std::vector<std::string>& messages) {
  Json encoded = Json::array();
  for (const std::string& message : messages) encoded.push_back(absl::Base64Escape(message));
  return encoded;
}

// Returns the path to the millimetre; of a long one, some of its points.
Json EncodePath(const std::vector<Eigen::Vector3d>& path) {
  const size_t stride = std::max<size_t>(1, (path.size() + kMostPathPoints - 1) / kMostPathPoints);
  Json encoded = Json::array();
  for (size_t i = 0; i < path.size(); i += stride) {
    if (!path[i].allFinite()) continue;
    for (const double value : path[i]) encoded.push_back(std::round(1e3 * value) / 1e3);
  }
  return encoded;
}

std::string WriteRecording(const ShownMission& mission,
                           const std::vector<std::vector<Eigen::Vector3d>>& truth) {
  Json paths = Json::array();
  for (const std::vector<Eigen::Vector3d>& path : truth) paths.push_back(EncodePath(path));
  const Json recording = {{"mission", mission.mission},
                          {"map", Encode(mission.map)},
                          {"hasPoints", mission.has_points},
                          {"hasPast", mission.has_past},
                          {"pulse", absl::Base64Escape(mission.pulse)},
                          {"overlaps", Encode(mission.overlaps)},
                          {"truth", paths}};
  // What is no UTF-8 is replaced, and nothing can end the script element or begin a comment in it.
  const std::string text = recording.dump(-1, ' ', true, Json::error_handler_t::replace);
  return absl::StrReplaceAll(text, {{"<", "\\u003c"}});
}

// Returns the text as a quoted attribute's value. Every other character stays what it is, for the
// policy allows exactly the script's and the style's own bytes.
std::string QuoteDocument(const std::string& document) {
  return absl::StrReplaceAll(document,
                             {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

}  // namespace

ViewerPage LoadViewerPage(const std::string& folder) {
  ViewerPage page{ReadText(folder + "/app.js"), ReadText(folder + "/app.css")};
  if (page.script.empty() || page.style.empty()) return {};
  return page;
}

std::string ViewerFrame(const ViewerPage& page, const ShownMission& mission,
                        const std::vector<std::vector<Eigen::Vector3d>>& truth) {
  const std::string document = absl::StrCat(
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"color-scheme\" content=\"light dark\"><style>",
      page.style,
      "</style></head><body><noscript>The map is drawn with a script; map.png beside this page "
      "shows it from above.</noscript><script type=\"application/json\" id=\"recording\">",
      WriteRecording(mission, truth), "</script><script type=\"module\">", page.script,
      "</script></body></html>");
  return absl::StrCat(
      "<iframe id=\"map\" title=\"The map in three dimensions\" sandbox=\"allow-scripts\" "
      "srcdoc=\"",
      QuoteDocument(document), "\"></iframe>\n");
}

}  // namespace corbslam::services
