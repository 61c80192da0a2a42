#include <algorithm>

#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::PageRequest;

namespace {

// Missions are asked for in lots of so many, and no further lot once the message has so many bytes:
// labels and agents' limits of one may be a tenth of a megabyte, and no message has more than four.
constexpr size_t kLot = 16;
constexpr size_t kEnoughBytes = 1 << 20;

}  // namespace

absl::Status MapStoreService::ListMissions(const IsShown& is_shown,
                                           const v1::ListMissionsRequest& request,
                                           v1::ListMissionsResponse* response) {
  ASSIGN_OR_RETURN(PageRequest page, ReadPage(request));
  size_t left = page.page_size;
  // The page ends with a mission that is shown, so that its token names no other one.
  bool may_end = false;
  do {
    const bool is_enough = response->ByteSizeLong() >= kEnoughBytes;
    page.page_size = is_enough ? 1 : std::min(left, kLot);
    ASSIGN_OR_RETURN(const auto found, store_.ListMissions(page));
    for (const auto& item : found.items) {
      may_end = is_shown(item.name);
      if (!may_end) continue;
      ToProto(item, response->add_missions());
      --left;
    }
    page.page_token = found.next_page_token;
    may_end = may_end && (left == 0 || response->ByteSizeLong() >= kEnoughBytes);
  } while (!may_end && !page.page_token.empty());
  response->set_next_page_token(page.page_token);
  return absl::OkStatus();
}

}  // namespace corbslam::services
