#include "map_store/state/mission_uid.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/util/checksum.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kDrawnDigits = 24;
constexpr size_t kDigits = kDrawnDigits + 8;

std::string CheckDigits(absl::string_view name, absl::string_view drawn) {
  return absl::StrFormat("%08x", ExtendCrc32c(ExtendCrc32c(0, drawn), name));
}

}  // namespace

std::string DrawMissionUid(absl::string_view name) {
  std::random_device random;
  std::string drawn;
  while (drawn.size() < kDrawnDigits) {
    drawn += absl::StrFormat("%08x", static_cast<uint32_t>(random()));
  }
  return absl::StrCat(drawn, CheckDigits(name, drawn));
}

bool IsMissionUid(absl::string_view text) {
  return text.size() == kDigits && std::ranges::all_of(text, [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

bool IsUidOf(absl::string_view name, absl::string_view uid) {
  return IsMissionUid(uid) &&
         uid.substr(kDrawnDigits) == CheckDigits(name, uid.substr(0, kDrawnDigits));
}

}  // namespace corbslam::map_store
