#include "client_agent/source/lists/numbered_pictures.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;

constexpr absl::string_view kEndings[] = {".png", ".jpg", ".jpeg", ".bmp",
                                          ".pgm", ".ppm", ".tif",  ".tiff"};

// The limit is eleven days at 10 frames a second.
constexpr size_t kMaxNumber = 9'999'999;

std::optional<size_t> NumberOf(const fs::path& file, absl::string_view prefix,
                               absl::string_view suffix) {
  const std::string ending = absl::AsciiStrToLower(file.extension().string());
  if (std::find(std::begin(kEndings), std::end(kEndings), ending) == std::end(kEndings)) {
    return std::nullopt;
  }
  const std::string stem = file.stem().string();
  absl::string_view digits = stem;
  if (!absl::ConsumePrefix(&digits, prefix) || !absl::ConsumeSuffix(&digits, suffix)) {
    return std::nullopt;
  }
  uint32_t number = 0;
  if (digits.find_first_not_of("0123456789") != absl::string_view::npos ||
      !absl::SimpleAtoi(digits, &number)) {
    return std::nullopt;
  }
  return number;
}

}  // namespace

absl::StatusOr<std::map<size_t, std::string>> ListNumberedPictures(const std::string& folder,
                                                                   absl::string_view prefix,
                                                                   absl::string_view suffix) {
  std::error_code error;
  std::map<size_t, std::string> pictures;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::optional<size_t> number = NumberOf(it->path().filename(), prefix, suffix);
    if (!number.has_value()) continue;
    const std::string path = absl::StrCat(folder, "/", it->path().filename().string());
    if (*number > kMaxNumber) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": its number must be at most ", kMaxNumber, ": is its name a time?"));
    }
    const auto [there, added] = pictures.emplace(*number, path);
    if (added) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("picture ", *number, " is there twice: ", std::min(there->second, path),
                     " and ", std::max(there->second, path)));
  }
  if (error) {
    return absl::NotFoundError(absl::StrCat("no folder ", folder, ": ", error.message()));
  }
  return pictures;
}

}  // namespace corbslam::client_agent
