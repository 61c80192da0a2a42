#include "services/server/server.h"

#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/ext/health_check_service_server_builder_option.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/server_builder.h>
#include <pthread.h>
#include <signal.h>

#include <chrono>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "services/runtime/address.h"
#include "services/runtime/callback_threads.h"
#include "services/runtime/listen_errors.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

void RegisterPlugins() {
  static const bool once = [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::channelz::experimental::InitChannelzService();
    return true;
  }();
  (void)once;
}

// Takes reflection out, which gRPC offers to every server of a process that links it.
class WithoutReflection : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments*) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    std::erase_if(*plugins,
                  [](const auto& plugin) { return plugin->name() == "proto_server_reflection"; });
  }
};

sigset_t StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  return signals;
}

int Milliseconds(absl::Duration duration) {
  return static_cast<int>(absl::ToInt64Milliseconds(duration));
}

void Configure(const ServerOptions& options, grpc::ServerBuilder& builder) {
  if (!options.reflection) builder.SetOption(std::make_unique<WithoutReflection>());
  if (!options.health) {
    builder.SetOption(std::make_unique<grpc::HealthCheckServiceServerBuilderOption>(nullptr));
  }
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.SetMaxSendMessageSize(kMaxMessageBytes);
  // Two servers on one port would share its calls.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  // Robots on bad links ping more often than the default allows.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(options.keepalive_time));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                             Milliseconds(options.keepalive_timeout));
  if (options.max_connection_age < absl::InfiniteDuration()) {
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS,
                               Milliseconds(options.max_connection_age));
  }
  // A robot that has nothing to say for long is pinged again and again.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> creators;
  if (options.rpc_observer != nullptr) {
    creators.push_back(MakeRpcInterceptors(options.rpc_observer));
  }
  if (options.auditor != nullptr) creators.push_back(MakeAuditInterceptors(options.auditor));
  if (!creators.empty()) builder.experimental().SetInterceptorCreators(std::move(creators));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const std::string& address,
                                                      const std::vector<grpc::Service*>& services,
                                                      const ServerOptions& options) {
  if (!address.empty()) RETURN_IF_ERROR(ParseListenAddress(address).status());
  RegisterPlugins();
  KeepCallbackThreads();
  grpc::ServerBuilder builder;
  Configure(options, builder);
  int port = 0;
  if (!address.empty()) builder.AddListeningPort(address, options.credentials, &port);
  for (grpc::Service* service : services) builder.RegisterService(service);
  std::unique_ptr<Server> server(new Server);
  server->server_ = builder.BuildAndStart();
  if (server->server_ == nullptr || (!address.empty() && port == 0)) {
    return absl::UnavailableError(
        absl::StrCat("can't listen on \"", address, "\": ", ExplainListenFailure(address)));
  }
  const std::string host = address.substr(0, address.rfind(':'));
  if (!address.empty()) server->address_ = absl::StrCat(host, ":", port);
  if (auto* health = server->server_->GetHealthCheckService()) {
    health->SetServingStatus(kLiveness, true);
  }
  server->SetReady(true);
  return server;
}

Server::~Server() { Shutdown(absl::ZeroDuration()); }

std::shared_ptr<grpc::Channel> Server::InProcessChannel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  arguments.SetMaxSendMessageSize(kMaxMessageBytes);
  return server_->InProcessChannel(arguments);
}

void Server::SetReady(bool ready) {
  auto* health = server_->GetHealthCheckService();
  if (health == nullptr) return;
  const bool serving = ready && !stopped_;
  health->SetServingStatus(kReadiness, serving);
  health->SetServingStatus("", serving);
}

void Server::Shutdown(absl::Duration drain) {
  if (server_ == nullptr || stopped_.exchange(true)) return;
  SetReady(false);
  server_->Shutdown(std::chrono::system_clock::now() + absl::ToChronoMilliseconds(drain));
  server_->Wait();
}

void BlockStopSignals() {
  const sigset_t signals = StopSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

void WaitForStopSignal() {
  const sigset_t signals = StopSignals();
  int received = 0;
  sigwait(&signals, &received);
}

void AnnounceAddress(const std::string& address) {
  std::cout << "listening on " << address << std::endl;
}

void AnnounceMetrics(const std::string& address) {
  std::cout << "metrics on " << address << std::endl;
}

void AnnounceFinished() { std::cout << "finished" << std::endl; }

}  // namespace corbslam::services
