// Decides for a service who may make which call.
#ifndef CORBSLAM_SERVICES_SERVER_DOOR_H_
#define CORBSLAM_SERVICES_SERVER_DOOR_H_

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"

namespace corbslam::services {

// Who made a call, which may have ended since. Must not outlive the door that it came through.
class KnownCaller {
 public:
  virtual ~KnownCaller() = default;
  // Returns a name for logs; empty: nobody knows who it is.
  virtual std::string name() const = 0;
  // Returns why the caller's streams may not stay open.
  virtual absl::Status MayStay() const = 0;
  // Returns true if lists that the caller asks for have this mission.
  virtual bool MayLook(const std::string& mission) const = 0;
};

// Thread-safe.
class Door {
 public:
  virtual ~Door() = default;
  // Returns OK if the caller may make this call with `message`: its request, or a message of the
  // caller's stream that says what the call is about.
  virtual absl::Status Check(const google::protobuf::MethodDescriptor& method,
                             const grpc::ServerContextBase& context,
                             const google::protobuf::Message& message) const = 0;
  virtual std::shared_ptr<const KnownCaller> Meet(const grpc::ServerContextBase& context) const = 0;
  // Has `listener` called each time when callers were told not to stay, as long as the door lives.
  virtual void OnRevoked(std::function<void()> listener) const = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_DOOR_H_
