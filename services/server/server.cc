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
#include "services/runtime/callback_threads.h"
#include "services/server/connection_calls.h"
#include "services/server/connection_front.h"
#include "services/server/listening.h"
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

// `front` may be null.
void Configure(const ServerOptions& options, ConnectionFront* front, grpc::ServerBuilder& builder) {
  if (!options.reflection) builder.SetOption(std::make_unique<WithoutReflection>());
  if (!options.health) {
    builder.SetOption(std::make_unique<grpc::HealthCheckServiceServerBuilderOption>(nullptr));
  }
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.SetMaxSendMessageSize(kMaxMessageBytes);
  // Robots on bad links ping more often than the default allows.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(options.keepalive_time));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                             Milliseconds(options.keepalive_timeout));
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                             Milliseconds(options.handshake_timeout));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS,
                             Milliseconds(options.max_connection_idle));
  if (options.max_connection_age < absl::InfiniteDuration()) {
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS,
                               Milliseconds(options.max_connection_age));
  }
  // A robot that has nothing to say for long is pinged again and again.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> creators;
  if (front != nullptr) creators.push_back(MakeConnectionInterceptors(front));
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
  RegisterPlugins();
  KeepCallbackThreads();
  std::unique_ptr<Server> server(new Server);
  if (!address.empty()) {
    ASSIGN_OR_RETURN(Listening listening, Listening::Open(address));
    server->address_ = absl::StrCat(address.substr(0, address.rfind(':')), ":", listening.port());
    server->front_ = std::make_unique<ConnectionFront>(
        std::move(listening),
        [raw = server.get()](int listener, int fd) { raw->HandOver(listener, fd); },
        ConnectionFrontOptions{.limits = options.connections,
                               .send_timeout = options.keepalive_timeout});
  }
  grpc::ServerBuilder builder;
  Configure(options, server->front_.get(), builder);
  if (server->front_ != nullptr) {
    server->acceptor_ = builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        options.credentials);
  }
  for (grpc::Service* service : services) builder.RegisterService(service);
  server->server_ = builder.BuildAndStart();
  if (server->server_ == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("gRPC can't serve \"", address, "\"; standard error may say why"));
  }
  server->SetAlive(true);
  server->SetReady(true);
  if (server->front_ != nullptr) server->front_->Start();
  return server;
}

void Server::HandOver(int listener, int fd) {
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
  connection.listener_fd = listener;
  connection.fd = fd;
  acceptor_->HandleNewConnection(&connection);
}

Server::Server() = default;

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

std::string Server::reachable() const { return front_ != nullptr ? front_->reachable() : ""; }

ConnectionCounts Server::connections() const {
  return front_ != nullptr ? front_->counts() : ConnectionCounts();
}

void Server::SetAlive(bool alive) {
  if (auto* health = server_->GetHealthCheckService()) health->SetServingStatus(kLiveness, alive);
}

void Server::Shutdown(absl::Duration drain) {
  if (server_ == nullptr || stopped_.exchange(true)) return;
  SetReady(false);
  if (front_ != nullptr) front_->Stop();
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
