#include "services/observe/metrics/rpc_metrics.h"

#include "absl/status/status.h"
#include "services/observe/metrics/buckets.h"

namespace corbslam::services {

RpcMetrics::RpcMetrics(prometheus::Registry& registry)
    : calls_(prometheus::BuildCounter()
                 .Name("corbslam_rpc_calls_total")
                 .Help("Calls that ended, by method and by gRPC's status code.")
                 .Register(registry)),
      running_(prometheus::BuildGauge()
                   .Name("corbslam_rpc_calls_running")
                   .Help("Calls under way, open streams among them.")
                   .Register(registry)),
      durations_(prometheus::BuildHistogram()
                     .Name("corbslam_rpc_duration_seconds")
                     .Help("From a call's beginning to its status; of streams their whole life.")
                     .Register(registry)),
      received_(prometheus::BuildHistogram()
                    .Name("corbslam_rpc_received_message_bytes")
                    .Help("Sizes of the messages received.")
                    .Register(registry)),
      sent_(prometheus::BuildHistogram()
                .Name("corbslam_rpc_sent_message_bytes")
                .Help("Sizes of the messages sent.")
                .Register(registry)) {}

RpcMetrics::Method RpcMetrics::Find(absl::string_view name) {
  absl::MutexLock lock(&mutex_);
  const auto known = methods_.find(name);
  if (known != methods_.end()) return known->second;
  const prometheus::Labels labels = {{"method", std::string(name)}};
  Method method;
  method.running = &running_.Add(labels);
  method.duration = &durations_.Add(labels, ShortTimes_s());
  method.received = &received_.Add(labels, MessageSizes_bytes());
  method.sent = &sent_.Add(labels, MessageSizes_bytes());
  return methods_.emplace(std::string(name), method).first->second;
}

void RpcMetrics::OnStarted(absl::string_view method) { Find(method).running->Increment(); }

void RpcMetrics::OnReceived(absl::string_view method, size_t bytes) {
  Find(method).received->Observe(static_cast<double>(bytes));
}

void RpcMetrics::OnSent(absl::string_view method, size_t bytes) {
  Find(method).sent->Observe(static_cast<double>(bytes));
}

void RpcMetrics::OnFinished(absl::string_view name, grpc::StatusCode code, absl::Duration took) {
  const Method method = Find(name);
  method.running->Decrement();
  method.duration->Observe(absl::ToDoubleSeconds(took));
  calls_
      .Add({{"method", std::string(name)},
            {"code", absl::StatusCodeToString(static_cast<absl::StatusCode>(code))}})
      .Increment();
}

}  // namespace corbslam::services
