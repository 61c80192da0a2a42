#include "client_agent/source/source_spec.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/foreign_files.h"
#include "client_agent/source/opening_options.h"
#include "client_agent/source/option_values.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

using KeyAndValue = std::pair<absl::string_view, absl::string_view>;

absl::Status ParseCount(absl::string_view key, absl::string_view value, size_t& count) {
  uint32_t parsed = 0;
  if (!absl::SimpleAtoi(value, &parsed)) return BadOption(key, value, "a number from 0 on");
  count = parsed;
  return absl::OkStatus();
}

absl::Status ParseFrames(absl::string_view value, FrameSelection& selection) {
  const KeyAndValue range = absl::StrSplit(value, absl::MaxSplits(':', 1));
  if (!absl::StrContains(value, ':')) return BadOption("frames", value, "FIRST:LAST");
  RETURN_IF_ERROR(ParseCount("frames", range.first.empty() ? "0" : range.first, selection.first));
  selection.last.reset();
  if (range.second.empty()) return absl::OkStatus();
  size_t last = 0;
  RETURN_IF_ERROR(ParseCount("frames", range.second, last));
  if (last < selection.first) return BadOption("frames", value, "FIRST not above LAST");
  selection.last = last;
  return absl::OkStatus();
}

// Options end at '&' and ','; values that hold these write them as URLs do. Any other '%' is one.
std::string Decoded(absl::string_view value) {
  return absl::StrReplaceAll(value, {{"%26", "&"}, {"%2C", ","}, {"%2c", ","}, {"%25", "%"}});
}

std::string Encoded(absl::string_view value) {
  return absl::StrReplaceAll(value, {{"&", "%26"},
                                     {",", "%2C"},
                                     {"%26", "%2526"},
                                     {"%2C", "%252C"},
                                     {"%2c", "%252c"},
                                     {"%25", "%2525"}});
}

SequencePart& PartOf(SourceSpec& spec) {
  return spec.selection.part.has_value() ? *spec.selection.part : spec.selection.part.emplace();
}

absl::Status ParseRobot(absl::string_view value, SequencePart& part) {
  const KeyAndValue parts = absl::StrSplit(value, absl::MaxSplits('/', 1));
  RETURN_IF_ERROR(ParseCount("robot", parts.first, part.robot));
  RETURN_IF_ERROR(ParseCount("robot", parts.second, part.robots));
  if (part.robot >= 1 && part.robot <= part.robots) return absl::OkStatus();
  return BadOption("robot", value, "K/N with K from 1 to N");
}

std::string ListKnownOptions(const SourceSpec& spec) {
  std::vector<absl::string_view> names;
  // A camera's frames are played as they come.
  if (spec.settings == nullptr || !spec.settings->is_live()) {
    names = {"frames",  "stride", "offset", "reverse", "robot",
             "overlap", "gamma",  "noise",  "cameras"};
  }
  if (spec.settings == nullptr) names.insert(names.end(), {"seed", "truth_frame"});
  const std::vector<absl::string_view> more =
      spec.settings == nullptr ? OpeningOptionNames(spec.layout) : spec.settings->OptionNames();
  names.insert(names.end(), more.begin(), more.end());
  return absl::StrJoin(names, ", ");
}

bool IsOptionOf(const KindSettings& settings, absl::string_view key) {
  const std::vector<absl::string_view> names = settings.OptionNames();
  return std::find(names.begin(), names.end(), key) != names.end();
}

absl::Status ApplyOption(absl::string_view key, absl::string_view value, SourceSpec& spec) {
  if (spec.settings != nullptr && IsOptionOf(*spec.settings, key)) {
    ASSIGN_OR_RETURN(spec.settings, spec.settings->With(key, value));
    spec.perturbation.seed = spec.settings->noise_seed();
    return absl::OkStatus();
  }
  if (IsOpeningOption(spec.layout, key)) return ApplyOpeningOption(key, value, spec.opening);
  if (key == "frames") return ParseFrames(value, spec.selection);
  if (key == "stride") {
    RETURN_IF_ERROR(ParseCount(key, value, spec.selection.stride));
    return spec.selection.stride > 0 ? absl::OkStatus() : BadOption(key, value, "at least 1");
  }
  if (key == "offset") return ParseCount(key, value, spec.selection.offset);
  if (key == "reverse") {
    return ParseFlag(key, value, spec.selection.reverse);
  }
  if (key == "cameras") {
    if (value != "1") return BadOption(key, value, "1, or left out for all that there are");
    spec.one_camera = true;
    return absl::OkStatus();
  }
  if (key == "robot") return ParseRobot(value, PartOf(spec));
  if (key == "overlap") return ParseCount(key, value, PartOf(spec).overlap);
  if (key == "gamma") return ParseReal(key, value, 0.05, 20, spec.perturbation.gamma);
  if (key == "noise") return ParseReal(key, value, 0, 100, spec.perturbation.noise_sigma);
  if (key == "seed" && spec.settings == nullptr) {
    if (absl::SimpleAtoi(value, &spec.perturbation.seed)) return absl::OkStatus();
    return BadOption(key, value, "a number from 0 on");
  }
  if (key == "truth_frame" && spec.settings == nullptr) {
    if (value.empty()) return BadOption(key, value, "a name");
    spec.truth_frame = std::string(value);
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("unknown source option '", key, "': known are ", ListKnownOptions(spec)));
}

constexpr std::pair<absl::string_view, SourceLayout> kLayouts[] = {
    {"kitti", SourceLayout::kKitti},
    {"euroc", SourceLayout::kEuroc},
    {"tum", SourceLayout::kTum},
    {"7scenes", SourceLayout::kSevenScenes}};

// Sets the layout of `spec`, whose place is set already, and the settings of a registered kind.
absl::Status ParseKind(absl::string_view name, SourceSpec& spec) {
  for (const auto& [known, layout] : kLayouts) {
    if (name != known) continue;
    spec.layout = layout;
    return absl::OkStatus();
  }
  const std::optional<SourceKind> kind = FindSourceKind(name);
  if (const std::string foreign = DescribeForeignFile(name); !kind && !foreign.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(name, ":", spec.directory, " is ", foreign));
  }
  if (!kind.has_value()) {
    return absl::InvalidArgumentError(absl::StrCat("unknown source layout '", name, "': known are ",
                                                   absl::StrJoin(KnownSourceKinds(), ", ")));
  }
  spec.layout = SourceLayout::kRegistered;
  ASSIGN_OR_RETURN(spec.settings, kind->make(spec.directory));
  return absl::OkStatus();
}

absl::string_view KindName(const SourceSpec& spec) {
  if (spec.settings != nullptr) return spec.settings->kind();
  for (const auto& [name, known] : kLayouts) {
    if (spec.layout == known) return name;
  }
  return "";
}

}  // namespace

std::vector<absl::string_view> RecordedLayoutNames() {
  std::vector<absl::string_view> names;
  for (const auto& [name, layout] : kLayouts) names.push_back(name);
  return names;
}

std::vector<size_t> FramesOf(const SourceSpec& spec, size_t frame_count) {
  std::vector<size_t> frames = SelectFrames(spec.selection, frame_count);
  if (spec.settings == nullptr || !spec.settings->turned()) return frames;
  for (size_t& frame : frames) frame = frame_count - 1 - frame;
  std::reverse(frames.begin(), frames.end());
  return frames;
}

absl::Status ApplyOptions(absl::string_view options, SourceSpec& spec) {
  for (const absl::string_view option :
       absl::StrSplit(options, absl::ByAnyChar("&,"), absl::SkipEmpty())) {
    const KeyAndValue parts = absl::StrSplit(option, absl::MaxSplits('=', 1));
    const std::string key = absl::StrReplaceAll(parts.first, {{"-", "_"}});
    RETURN_IF_ERROR(ApplyOption(key, Decoded(parts.second), spec));
  }
  return absl::OkStatus();
}

absl::Status UseRig(const std::string& path, SourceSpec& spec) {
  return ApplyOption("rig", path, spec);
}

namespace {

// Splits at the first '?', or at a later one before which there is an existing folder.
KeyAndValue SplitOffOptions(absl::string_view text) {
  for (size_t end = text.size(); end != absl::string_view::npos && end > 0;
       end = text.rfind('?', end - 1)) {
    const absl::string_view folder = text.substr(0, end);
    if (!absl::StrContains(folder, '?')) break;
    std::error_code ignored;
    if (!std::filesystem::is_directory(std::string(folder), ignored)) continue;
    return {folder, text.substr(std::min(end + 1, text.size()))};
  }
  return absl::StrSplit(text, absl::MaxSplits('?', 1));
}

}  // namespace

absl::StatusOr<SourceSpec> ParseSourceSpec(absl::string_view text) {
  // The file system would end the path there, and find something else than what is written.
  if (const size_t zero = text.find('\0'); zero != absl::string_view::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat("source '", absl::CEscape(text), "' holds a zero byte at ", zero));
  }
  if (!absl::StrContains(text, ':')) {
    const std::string foreign = DescribeForeignFile(text.substr(0, text.find('?')));
    if (!foreign.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("source '", text, "' is ", foreign));
    }
    return absl::InvalidArgumentError(
        absl::StrCat("source '", text, "' is not LAYOUT:DIR, for example kitti:DIR"));
  }
  const KeyAndValue layout_and_rest = absl::StrSplit(text, absl::MaxSplits(':', 1));
  const KeyAndValue directory_and_options = SplitOffOptions(layout_and_rest.second);
  SourceSpec spec;
  spec.directory = std::string(directory_and_options.first);
  if (spec.directory.empty()) {
    // A kind of camera says what is to be named.
    if (ParseKind(layout_and_rest.first, spec).ok() && spec.settings != nullptr) {
      RETURN_IF_ERROR(spec.settings->Validate());
    }
    return absl::InvalidArgumentError(absl::StrCat("source '", text, "' names no directory"));
  }
  while (spec.directory.size() > 1 && spec.directory.back() == '/') spec.directory.pop_back();
  RETURN_IF_ERROR(ParseKind(layout_and_rest.first, spec));
  RETURN_IF_ERROR(ApplyOptions(directory_and_options.second, spec));
  if (spec.settings != nullptr) RETURN_IF_ERROR(spec.settings->Validate());
  return spec;
}

std::string FormatSourceSpec(const SourceSpec& spec) {
  const SourceSpec plain;
  std::vector<std::string> options;
  if (spec.settings != nullptr) {
    for (const auto& [key, value] : spec.settings->FormatOptions()) {
      options.push_back(absl::StrCat(key, "=", Encoded(value)));
    }
  }
  for (const auto& [key, value] : FormatOpening(spec.opening)) {
    options.push_back(absl::StrCat(key, "=", Encoded(value)));
  }
  for (std::string& option : FormatSelection(spec.selection)) {
    options.push_back(std::move(option));
  }
  if (spec.perturbation.gamma != plain.perturbation.gamma) {
    options.push_back(absl::StrCat("gamma=", FormatReal(spec.perturbation.gamma)));
  }
  if (spec.perturbation.noise_sigma != plain.perturbation.noise_sigma) {
    options.push_back(absl::StrCat("noise=", FormatReal(spec.perturbation.noise_sigma)));
  }
  if (spec.settings == nullptr && spec.perturbation.seed != plain.perturbation.seed) {
    options.push_back(absl::StrCat("seed=", spec.perturbation.seed));
  }
  if (spec.one_camera) options.push_back("cameras=1");
  if (!spec.truth_frame.empty()) {
    options.push_back(absl::StrCat("truth_frame=", Encoded(spec.truth_frame)));
  }
  const bool is_plain = options.empty() && !absl::StrContains(spec.directory, '?');
  return absl::StrCat(KindName(spec), ":", spec.directory, is_plain ? "" : "?",
                      absl::StrJoin(options, "&"));
}

}  // namespace corbslam::client_agent
