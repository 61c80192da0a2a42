#include <utility>

#include "client_agent/source/pictures/mask_picture.h"
#include "services/agent_service/agent_service.h"
#include "services/agent_service/mask_png.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::AgentOrders;

grpc::ServerUnaryReactor* AgentService::Give(grpc::CallbackServerContext* context, Order order) {
  return AnswerOn(pool_, context, [this, order = std::move(order)]() -> absl::Status {
    if (options_.orders == nullptr) {
      return absl::UnimplementedError("this robot takes no orders");
    }
    return order(*options_.orders);
  });
}

grpc::ServerUnaryReactor* AgentService::PauseMapping(grpc::CallbackServerContext* context,
                                                     const v1::PauseMappingRequest*,
                                                     v1::PauseMappingResponse*) {
  return Give(context, [](AgentOrders& orders) { return orders.PauseMapping(true); });
}

grpc::ServerUnaryReactor* AgentService::ResumeMapping(grpc::CallbackServerContext* context,
                                                      const v1::ResumeMappingRequest*,
                                                      v1::ResumeMappingResponse*) {
  return Give(context, [](AgentOrders& orders) { return orders.PauseMapping(false); });
}

grpc::ServerUnaryReactor* AgentService::OpenNewMap(grpc::CallbackServerContext* context,
                                                   const v1::OpenNewMapRequest*,
                                                   v1::OpenNewMapResponse*) {
  return Give(context, [](AgentOrders& orders) { return orders.OpenLocalMap(); });
}

grpc::ServerUnaryReactor* AgentService::SetMask(grpc::CallbackServerContext* context,
                                                const v1::SetMaskRequest* request,
                                                v1::SetMaskResponse* response) {
  return Give(context, [request, response](AgentOrders& orders) -> absl::Status {
    ASSIGN_OR_RETURN(const PictureMask mask, DecodeMask(request->png()));
    RETURN_IF_ERROR(orders.SetMask(mask));
    response->set_masked_percent(client_agent::MaskedPercent(mask));
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
