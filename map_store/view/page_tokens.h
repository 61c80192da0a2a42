// The pages of lists whose items come and go between two requests.
#ifndef CORBSLAM_MAP_STORE_VIEW_PAGE_TOKENS_H_
#define CORBSLAM_MAP_STORE_VIEW_PAGE_TOKENS_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "map_store/state/lookups.h"

namespace corbslam::map_store {

// Where a page begins. A page ends with a token that names its last item by a key in whose order
// the list is, so that the next page begins behind that item whatever came or went meanwhile.
struct PageStart {
  std::string list;   // Which list of what, with which filter; the token is good for no other.
  std::string after;  // The key of the last item given out; empty: the first page.
  size_t size = 0;    // How many items at most.
};

// Reads a request; `list` is any text that is the same for each page of one list. Returns
// INVALID_ARGUMENT if the token is not one that this list gave out.
absl::StatusOr<PageStart> ReadPageStart(const PageRequest& request, size_t max_page_size,
                                        std::string list);
absl::Status NoSuchPageToken();

// Returns the token of a page that ends with the item of this key.
std::string MakePageToken(const PageStart& start, absl::string_view last);

// Takes out the items beyond the page: `items` has those of the page, and one more if there is one.
// Returns the token of the next page, empty for none; `key_of` returns an item's key.
template <typename T, typename KeyOf>
std::string EndPage(const PageStart& start, std::vector<T>& items, const KeyOf& key_of) {
  if (items.size() <= start.size) return "";
  while (items.size() > start.size) items.pop_back();
  return MakePageToken(start, key_of(items.back()));
}

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_PAGE_TOKENS_H_
