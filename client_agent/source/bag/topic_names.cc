#include "client_agent/source/bag/topic_names.h"

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace corbslam::client_agent {
namespace {

// How the two cameras of a pair are called, left first; KITTI's colour pair is 02 and 03.
constexpr std::pair<absl::string_view, absl::string_view> kSides[] = {
    {"left", "right"},        {"Left", "Right"},        {"LEFT", "RIGHT"},
    {"cam0", "cam1"},         {"cam_0", "cam_1"},       {"cam1", "cam2"},
    {"camera0", "camera1"},   {"camera_0", "camera_1"}, {"camera1", "camera2"},
    {"camera_1", "camera_2"}, {"image_0", "image_1"},   {"image_2", "image_3"},
    {"image_00", "image_01"}, {"image_02", "image_03"}, {"infra1", "infra2"},
    {"fisheye1", "fisheye2"}, {"/l/", "/r/"},           {"/0/", "/1/"}};

bool HasAny(absl::string_view name, std::initializer_list<absl::string_view> words) {
  const std::string lower = absl::AsciiStrToLower(name);
  return std::any_of(words.begin(), words.end(),
                     [&](absl::string_view word) { return absl::StrContains(lower, word); });
}

std::string Parent(absl::string_view topic) {
  const size_t slash = topic.rfind('/');
  return std::string(topic.substr(0, slash == absl::string_view::npos ? 0 : slash));
}

}  // namespace

std::string BaseTopic(absl::string_view topic) {
  for (const absl::string_view ending : {"/compressedDepth", "/compressed"}) {
    if (absl::ConsumeSuffix(&topic, ending)) break;
  }
  return std::string(topic);
}

std::vector<std::string> CameraInfoTopics(absl::string_view base) {
  const std::string parent = Parent(base);
  return {absl::StrCat(parent, "/camera_info"), absl::StrCat(base, "/camera_info"),
          absl::StrCat(base, "_camera_info"), absl::StrCat(base, "_info"),
          absl::StrCat(Parent(parent), "/camera_info")};
}

bool AreLeftAndRight(absl::string_view left, absl::string_view right) {
  return std::any_of(std::begin(kSides), std::end(kSides), [&](const auto& side) {
    return absl::StrContains(left, side.first) &&
           absl::StrReplaceAll(left, {{side.first, side.second}}) == right;
  });
}

bool SaysRectified(absl::string_view base) {
  return HasAny(base, {"rect"}) && !HasAny(base, {"unrect", "not_rect", "nonrect", "non_rect"});
}

bool SaysRegistered(absl::string_view base) {
  return HasAny(base, {"registered", "aligned", "to_color", "to_colour", "to_rgb"});
}

bool SaysNoDepth(absl::string_view base) {
  return HasAny(base, {"infra", "/ir/", "thermal", "confidence", "disparity", "amplitude"});
}

bool SaysDepth(absl::string_view base) { return HasAny(base, {"depth"}); }

size_t CommonParts(absl::string_view a, absl::string_view b) {
  const std::vector<absl::string_view> first = absl::StrSplit(a, '/', absl::SkipEmpty());
  const std::vector<absl::string_view> second = absl::StrSplit(b, '/', absl::SkipEmpty());
  size_t common = 0;
  while (common < std::min(first.size(), second.size()) && first[common] == second[common]) {
    ++common;
  }
  return common;
}

}  // namespace corbslam::client_agent
