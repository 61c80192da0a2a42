// Finds the map store that has a mission: the one that was named, or where that one sends.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_STORE_ROUTE_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_STORE_ROUTE_H_

#include <grpcpp/channel.h>
#include <grpcpp/security/credentials.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

// Makes a channel to another store, under the rules of the first one. INVALID_ARGUMENT: what it is
// given is no address of a server.
using ConnectToOther =
    std::function<absl::StatusOr<std::shared_ptr<grpc::Channel>>(const std::string& address)>;
// Returns one that demands what `credentials` do, and shows what they have.
ConnectToOther ConnectWith(std::shared_ptr<grpc::ChannelCredentials> credentials);

// Knows where one mission is. A caller makes a call over channel() and tells how it ended. Where
// that is another store (slam/exchange/mission_elsewhere.h), the next call goes there; where a
// store is not reached, the next one goes to the other of the two. Thread-safe.
class StoreRoute {
 public:
  // One attempt is sent on so often at most.
  static constexpr int kMaxHops = 4;

  // `named` is the store that was named. Without `connect` nobody is followed.
  explicit StoreRoute(std::shared_ptr<grpc::Channel> named, ConnectToOther connect = nullptr)
      : named_(std::move(named)), connect_(std::move(connect)) {}

  // Returns the channel to the store that is to be asked now.
  std::shared_ptr<grpc::Channel> channel() const ABSL_LOCKS_EXCLUDED(mutex_);
  std::unique_ptr<v1::MapStore::Stub> NewStub() const { return v1::MapStore::NewStub(channel()); }

  // Notes how a call over the channel `asked` ended. Returns whether it is to be made again at
  // once, elsewhere; `hops` counts that for the attempt, and is 0 at its beginning. Where a store
  // sends on and can't be followed, the status says why.
  bool Follow(const std::shared_ptr<grpc::Channel>& asked, absl::Status& status, int& hops)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Makes a call until it is not sent on any more.
  template <typename Call>
  absl::Status Ask(Call call) {
    int hops = 0;
    while (true) {
      const std::shared_ptr<grpc::Channel> asked = channel();
      absl::Status status = call(*v1::MapStore::NewStub(asked));
      if (!Follow(asked, status, hops)) return status;
    }
  }

 private:
  // Goes to the store at `address` from here on.
  absl::Status GoTo(const std::string& address) ABSL_LOCKS_EXCLUDED(mutex_);
  void GoElsewhere(const std::shared_ptr<grpc::Channel>& asked) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::shared_ptr<grpc::Channel> named_;
  const ConnectToOther connect_;
  mutable absl::Mutex mutex_;
  // Where the mission was last said to be; null: nobody has sent on yet.
  std::shared_ptr<grpc::Channel> other_ ABSL_GUARDED_BY(mutex_);
  std::string other_address_ ABSL_GUARDED_BY(mutex_);
  bool at_other_ ABSL_GUARDED_BY(mutex_) = false;
};

// Has a route for each mission. Thread-safe.
class StoreRoutes {
 public:
  explicit StoreRoutes(std::shared_ptr<grpc::Channel> named, ConnectToOther connect = nullptr)
      : named_(std::move(named)), connect_(std::move(connect)) {}

  const std::shared_ptr<grpc::Channel>& named() const { return named_; }
  std::shared_ptr<StoreRoute> Of(const std::string& mission) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Beyond so many the routes that nobody uses are forgotten.
  static constexpr size_t kMaxRoutes = 1000;

  const std::shared_ptr<grpc::Channel> named_;
  const ConnectToOther connect_;
  absl::Mutex mutex_;
  std::map<std::string, std::shared_ptr<StoreRoute>> routes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_STORE_ROUTE_H_
