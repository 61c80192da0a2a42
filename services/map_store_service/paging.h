// Reads pages of lists, as the contract says.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_PAGING_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_PAGING_H_

#include <algorithm>
#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "map_store/state/lookups.h"

namespace corbslam::services {

inline constexpr int kDefaultPageSize = 100;
inline constexpr int kMaxPageSize = 1000;

// Reads the page of any request with page_size and page_token.
template <typename Request>
absl::StatusOr<map_store::PageRequest> ReadPage(const Request& request) {
  const int32_t size = request.page_size();
  if (size < 0) {
    return absl::InvalidArgumentError(absl::StrCat("page_size is ", size, ", must be at least 0"));
  }
  map_store::PageRequest page;
  page.page_size = static_cast<size_t>(size == 0 ? kDefaultPageSize : std::min(size, kMaxPageSize));
  page.page_token = request.page_token();
  return page;
}

// Returns the items of all pages of a list; `list` takes a PageRequest.
template <typename Item, typename List>
absl::StatusOr<std::vector<Item>> ReadAllPages(const List& list) {
  std::vector<Item> all;
  map_store::PageRequest request;
  do {
    absl::StatusOr<map_store::Page<Item>> page = list(request);
    if (!page.ok()) return page.status();
    all.insert(all.end(), page->items.begin(), page->items.end());
    request.page_token = page->next_page_token;
  } while (!request.page_token.empty());
  return all;
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_PAGING_H_
