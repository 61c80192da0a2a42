// Serves calls that go through a door each, before their own code runs.
#ifndef CORBSLAM_SERVICES_SERVER_GUARDED_SERVICE_H_
#define CORBSLAM_SERVICES_SERVER_GUARDED_SERVICE_H_

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <grpcpp/impl/codegen/server_callback_handlers.h>
#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/server_callback.h>

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "services/server/door.h"
#include "services/server/refusal.h"
#include "services/server/task_pool.h"
#include "services/server/unary.h"

namespace corbslam::services {

// Returns OK if the caller of a stream may have what this message of it asks for.
using MayAsk = std::function<absl::Status(const google::protobuf::Message&)>;

// The base of a service whose calls are members of the class derived from it. A request is shown to
// the door before the call's own code runs. A call whose caller streams must ask for itself, by the
// question that it is given, about each message that begins something. A call that is not served is
// UNIMPLEMENTED.
class GuardedService : public grpc::Service {
 protected:
  using Context = grpc::CallbackServerContext;
  template <typename Self, typename Request, typename Response>
  using Unary = grpc::ServerUnaryReactor* (Self::*)(Context*, const Request*, Response*);
  template <typename Self, typename Request, typename Response>
  using Answer = absl::Status (Self::*)(const Request&, Response*);
  template <typename Self, typename Request, typename Response>
  using Writing = grpc::ServerWriteReactor<Response>* (Self::*)(Context*, const Request*);
  template <typename Self, typename Request, typename Response>
  using Reading = grpc::ServerReadReactor<Request>* (Self::*)(Context*, MayAsk, Response*);
  template <typename Self, typename Request, typename Response>
  using Talking = grpc::ServerBidiReactor<Request, Response>* (Self::*)(Context*, MayAsk);

  // `service` is of the compiled-in contract. A null door lets everybody through.
  GuardedService(const google::protobuf::ServiceDescriptor& service,
                 std::shared_ptr<const Door> door)
      : service_(service), door_(std::move(door)) {}

  // May be null.
  const Door* door() const { return door_.get(); }
  const google::protobuf::ServiceDescriptor& service() const { return service_; }

  // Serves the call of this name by `call`. Its messages must be those of the contract, or bytes;
  // ends the process otherwise. Called in the constructor.
  template <typename Request, typename Response>
  void Serve(const char* name,
             std::function<grpc::ServerUnaryReactor*(Context*, const Request*, Response*)> call) {
    const Method& method = Find<Request, Response>(name, {.reads = false, .writes = false});
    Add(method, new grpc::internal::CallbackUnaryHandler<Request, Response>(
                    [this, &method, call = std::move(call)](
                        Context* context, const Request* request, Response* response) {
                      const absl::Status status = Check(method, *context, *request);
                      if (!status.ok()) return RefuseCall(context, status);
                      return call(context, request, response);
                    }));
  }
  template <typename Self, typename Request, typename Response>
  void Serve(const char* name, Unary<Self, Request, Response> call) {
    Serve<Request, Response>(
        name, [this, call](Context* context, const Request* request, Response* response) {
          return (static_cast<Self*>(this)->*call)(context, request, response);
        });
  }
  // Likewise, on `pool` (AnswerOn).
  template <typename Self, typename Request, typename Response>
  void Serve(const char* name, TaskPool& pool, Answer<Self, Request, Response> call) {
    Serve<Request, Response>(
        name, [this, &pool, call](Context* context, const Request* request, Response* response) {
          return AnswerOn(pool, context, [this, call, request, response] {
            return (static_cast<Self*>(this)->*call)(*request, response);
          });
        });
  }
  template <typename Self, typename Request, typename Response>
  void Serve(const char* name, Writing<Self, Request, Response> call) {
    const Method& method = Find<Request, Response>(name, {.reads = false, .writes = true});
    Add(method,
        new grpc::internal::CallbackServerStreamingHandler<Request, Response>(
            [this, &method, call](Context* context,
                                  const Request* request) -> grpc::ServerWriteReactor<Response>* {
              const absl::Status status = Check(method, *context, *request);
              if (!status.ok()) return new RefusedStream<Response>(status);
              return (static_cast<Self*>(this)->*call)(context, request);
            }));
  }
  template <typename Self, typename Request, typename Response>
  void Serve(const char* name, Reading<Self, Request, Response> call) {
    const Method& method = Find<Request, Response>(name, {.reads = true, .writes = false});
    Add(method, new grpc::internal::CallbackClientStreamingHandler<Request, Response>(
                    [this, &method, call](Context* context, Response* response) {
                      return (static_cast<Self*>(this)->*call)(context, Ask(method, context),
                                                               response);
                    }));
  }
  template <typename Self, typename Request, typename Response>
  void Serve(const char* name, Talking<Self, Request, Response> call) {
    const Method& method = Find<Request, Response>(name, {.reads = true, .writes = true});
    Add(method, new grpc::internal::CallbackBidiHandler<Request, Response>(
                    [this, &method, call](Context* context) {
                      return (static_cast<Self*>(this)->*call)(context, Ask(method, context));
                    }));
  }

 private:
  using Method = google::protobuf::MethodDescriptor;

  // Says whether the server reads a stream of messages, and whether it writes one.
  struct Streams {
    bool reads = false;
    bool writes = false;
  };

  template <typename Message>
  static const google::protobuf::Descriptor* TypeOf() {
    if constexpr (std::is_base_of_v<google::protobuf::Message, Message>) {
      return Message::descriptor();
    }
    return nullptr;
  }
  template <typename Request, typename Response>
  const Method& Find(const char* name, Streams streams) const {
    return Find(name, streams, TypeOf<Request>(), TypeOf<Response>());
  }
  // Null types are those of bytes.
  const Method& Find(const char* name, Streams streams, const google::protobuf::Descriptor* request,
                     const google::protobuf::Descriptor* response) const;
  void Add(const Method& method, grpc::internal::MethodHandler* handler);
  absl::Status Check(const Method& method, const Context& context,
                     const google::protobuf::Message& message) const {
    return door_ == nullptr ? absl::OkStatus() : door_->Check(method, context, message);
  }
  // The call's context must outlive what this returns.
  MayAsk Ask(const Method& method, const Context* context) const {
    return [this, &method, context](const google::protobuf::Message& message) {
      return Check(method, *context, message);
    };
  }

  const google::protobuf::ServiceDescriptor& service_;
  const std::shared_ptr<const Door> door_;
  std::deque<std::string> paths_;  // gRPC refers to them.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_GUARDED_SERVICE_H_
