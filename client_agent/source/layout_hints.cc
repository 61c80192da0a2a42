#include "client_agent/source/layout_hints.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/foreign_files.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;

struct LayoutSigns {
  SourceLayout layout;
  // Any of these, seen from the sequence's folder, gives the layout away.
  std::vector<const char*> signs;
};

const std::array<LayoutSigns, 4>& SignsOfLayouts() {
  static const auto& all = *new std::array<LayoutSigns, 4>{
      LayoutSigns{SourceLayout::kKitti, {"image_0", "image_2", "image_00/data", "image_02/data"}},
      LayoutSigns{SourceLayout::kEuroc, {"mav0/cam0", "cam0/data.csv"}},
      LayoutSigns{SourceLayout::kTum, {"associated.txt", "associations.txt", "rgb.txt"}},
      LayoutSigns{SourceLayout::kSevenScenes, {"frame-000000.color.png"}}};
  return all;
}

bool IsLike(const fs::path& folder, const LayoutSigns& of_layout) {
  return std::ranges::any_of(of_layout.signs, [&](const char* sign) {
    std::error_code ignored;
    return fs::exists(folder / sign, ignored);
  });
}

// Returns the first folder in `folder`, by name, that looks like the layout.
std::optional<std::string> FolderWithin(const std::string& folder, const LayoutSigns& of_layout) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (IsLike(entry->path(), of_layout)) found.push_back(entry->path().string());
  }
  if (found.empty()) return std::nullopt;
  return *std::ranges::min_element(found);
}

// Returns the spec as it is to be typed.
std::string Spec(const LayoutSigns& of_layout, const std::string& folder) {
  SourceSpec spec;
  spec.layout = of_layout.layout;
  spec.directory = folder;
  return FormatSourceSpec(spec);
}

std::string Hint(const SourceSpec& spec) {
  const auto asked = std::ranges::find(SignsOfLayouts(), spec.layout, &LayoutSigns::layout);
  if (asked == SignsOfLayouts().end() || IsLike(spec.directory, *asked)) return "";
  for (const LayoutSigns& of_layout : SignsOfLayouts()) {
    if (!IsLike(spec.directory, of_layout)) continue;
    return absl::StrCat(". It looks like a folder for ", Spec(of_layout, spec.directory));
  }
  const std::optional<std::string> within = FolderWithin(spec.directory, *asked);
  if (!within.has_value()) return "";
  return absl::StrCat(". Is ", Spec(*asked, *within), " meant?");
}

}  // namespace

absl::Status WithLayoutHint(const absl::Status& error, const SourceSpec& spec) {
  std::error_code unreachable;
  const fs::file_type type = fs::status(spec.directory, unreachable).type();
  switch (type) {
    case fs::file_type::directory:
      return {error.code(), absl::StrCat(error.message(), Hint(spec))};
    case fs::file_type::not_found:
      return absl::NotFoundError(absl::StrCat(spec.directory, ": there is no such folder"));
    case fs::file_type::none:
      return absl::PermissionDeniedError(absl::StrCat(spec.directory, ": ", unreachable.message()));
    default: {
      const std::string foreign = DescribeForeignFile(spec.directory);
      return absl::InvalidArgumentError(
          foreign.empty()
              ? absl::StrCat(spec.directory, ": a file; wanted is the folder of the sequence")
              : absl::StrCat(spec.directory, ": ", foreign));
    }
  }
}

}  // namespace corbslam::client_agent
