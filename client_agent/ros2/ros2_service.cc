#include "client_agent/ros2/ros2_service.h"

#include <ros2_types.h>

#include <utility>

#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

template <typename Request, typename Response>
absl::Status Serve(Ros2Node& node, const std::string& service,
                   const dds_topic_descriptor_t& request_type,
                   const dds_topic_descriptor_t& response_type,
                   std::function<absl::StatusOr<std::string>(const Request&)> call) {
  ASSIGN_OR_RETURN(Ros2Publisher* const responses,
                   node.Advertise(DdsResponseTopic(service), response_type, kDefaultQos));
  return node
      .Subscribe(DdsRequestTopic(service), request_type, kDefaultQos,
                 [responses, call = std::move(call)](const void* sample) {
                   const auto& request = *static_cast<const Request*>(sample);
                   const absl::StatusOr<std::string> done = call(request);
                   std::string message = done.ok() ? *done : std::string(done.status().message());
                   Response response = {};
                   response.client = request.client;
                   response.number = request.number;
                   response.success = done.ok();
                   response.message = message.data();
                   responses->Publish(&response);
                 })
      .status();
}

}  // namespace

absl::Status ServeTrigger(Ros2Node& node, const std::string& service, TriggerCall call) {
  using Request = std_srvs_srv_dds__Trigger_Request_;
  return Serve<Request, std_srvs_srv_dds__Trigger_Response_>(
      node, service, std_srvs_srv_dds__Trigger_Request__desc,
      std_srvs_srv_dds__Trigger_Response__desc,
      [call = std::move(call)](const Request&) { return call(); });
}

absl::Status ServeSetBool(Ros2Node& node, const std::string& service, SetBoolCall call) {
  using Request = std_srvs_srv_dds__SetBool_Request_;
  return Serve<Request, std_srvs_srv_dds__SetBool_Response_>(
      node, service, std_srvs_srv_dds__SetBool_Request__desc,
      std_srvs_srv_dds__SetBool_Response__desc,
      [call = std::move(call)](const Request& request) { return call(request.data); });
}

}  // namespace corbslam::client_agent
