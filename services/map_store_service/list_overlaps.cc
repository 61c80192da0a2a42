#include "absl/strings/str_cat.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::OverlapFilter;
using map_store::PageRequest;

grpc::ServerUnaryReactor* MapStoreService::ListOverlaps(grpc::CallbackServerContext* context,
                                                        const v1::ListOverlapsRequest* request,
                                                        v1::ListOverlapsResponse* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->parent()));
    OverlapFilter filter;
    if (request->accepted_only()) filter.accepted = true;
    if (!request->local_map().empty()) {
      ASSIGN_OR_RETURN(const LocalMapPath path,
                       ParseLocalMapName(request->local_map(), /*may_be_all=*/false));
      if (path.mission != mission) {
        return absl::InvalidArgumentError(absl::StrCat("local_map ", request->local_map(),
                                                       " is not of parent ", request->parent()));
      }
      filter.local_map = path.local_map;
    }
    ASSIGN_OR_RETURN(const PageRequest page, ReadPage(*request));
    ASSIGN_OR_RETURN(const auto found, store_.ListOverlaps(mission, filter, page));
    for (const auto& item : found.items) ToProto(mission, item, response->add_overlaps());
    response->set_next_page_token(found.next_page_token);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
