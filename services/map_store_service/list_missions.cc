#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::PageRequest;

grpc::ServerUnaryReactor* MapStoreService::ListMissions(grpc::CallbackServerContext* context,
                                                        const v1::ListMissionsRequest* request,
                                                        v1::ListMissionsResponse* response) {
  const ListFilter shows = options_.may_list != nullptr ? options_.may_list(*context) : nullptr;
  return AnswerOn(pool_, context, [this, shows, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(PageRequest page, ReadPage(*request));
    // The page is full with a mission that is shown, so that its token names no other one.
    do {
      ASSIGN_OR_RETURN(const auto found, store_.ListMissions(page));
      for (const auto& item : found.items) {
        if (shows != nullptr && !shows(item.name)) continue;
        ToProto(item, response->add_missions());
        --page.page_size;
      }
      page.page_token = found.next_page_token;
    } while (page.page_size > 0 && !page.page_token.empty());
    response->set_next_page_token(page.page_token);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
