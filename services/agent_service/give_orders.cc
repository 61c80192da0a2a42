#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/agent_service/agent_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::AgentOrders;

namespace {

constexpr size_t kMaxMaskBytes = 4 << 20;
constexpr absl::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);

// Returns the mask of a PNG, empty for no bytes.
absl::StatusOr<PictureMask> DecodeMask(const std::string& png) {
  if (png.empty()) return PictureMask();
  if (png.size() > kMaxMaskBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("png has ", png.size(), " bytes, must have at most ", kMaxMaskBytes));
  }
  if (!absl::StartsWith(png, kPngSignature)) {
    return absl::InvalidArgumentError("png does not begin as a PNG does");
  }
  // OpenCV reads from the bytes alone. It throws for pictures beyond its limits.
  const cv::Mat bytes(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data()));
  cv::Mat mask;
  try {
    mask = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("png can't be decoded: ", error.err));
  }
  if (mask.empty()) return absl::InvalidArgumentError("png can't be decoded");
  return mask;
}

double MaskedPercent(const PictureMask& mask) {
  if (mask.empty()) return 0;
  return 100.0 *
         (1.0 - static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total()));
}

}  // namespace

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
    response->set_masked_percent(MaskedPercent(mask));
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
