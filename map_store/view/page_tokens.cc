#include "map_store/view/page_tokens.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "slam/util/checksum.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kSumBytes = 4;

// Returns a checksum of the list and the key, so that neither another list's token nor a made-up
// one is taken.
std::string SumOf(absl::string_view list, absl::string_view key) {
  const uint32_t sum = ExtendCrc32c(0, absl::StrCat(list, absl::string_view("\0", 1), key));
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(sum >> shift);
  return bytes;
}

}  // namespace

absl::Status NoSuchPageToken() {
  return absl::InvalidArgumentError(
      "page_token is not one that this list gave out: take next_page_token of the page before, "
      "with "
      "the same parent and filter, or none to begin again");
}

absl::StatusOr<PageStart> ReadPageStart(const PageRequest& request, size_t max_page_size,
                                        std::string list) {
  PageStart start = {.list = std::move(list), .after = "", .size = max_page_size};
  if (request.page_size != 0) start.size = std::min(request.page_size, max_page_size);
  if (request.page_token.empty()) return start;
  std::string bytes;
  if (!absl::WebSafeBase64Unescape(request.page_token, &bytes) || bytes.size() <= kSumBytes) {
    return NoSuchPageToken();
  }
  start.after = bytes.substr(kSumBytes);
  if (request.page_token != MakePageToken(start, start.after)) return NoSuchPageToken();
  return start;
}

std::string MakePageToken(const PageStart& start, absl::string_view last) {
  return absl::WebSafeBase64Escape(absl::StrCat(SumOf(start.list, last), last));
}

}  // namespace corbslam::map_store
