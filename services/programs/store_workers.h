// Connects a map store to fusion workers: those that its flags name, and those that other stores
// offer.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_

#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/mission_leases.h"
#include "services/client/remote/remote_fusion_worker.h"
#include "services/security/security_options.h"

namespace corbslam::services {

// Thread-safe.
class StoreWorkers {
 public:
  // INVALID_ARGUMENT if the flags of `security` are wrong.
  static absl::StatusOr<std::unique_ptr<StoreWorkers>> Connect(std::vector<std::string> addresses,
                                                               const SecurityOptions& security);

  // The workers as one. If none of them takes a request, its error has the cause, which is looked
  // for at most twice a minute for each.
  FusionWorker* worker() const { return workers_.get(); }
  const std::vector<std::string>& own() const { return own_; }
  // Uses those workers, too, from here on.
  void UseOffered(const std::set<std::string>& offered);

 private:
  StoreWorkers(std::vector<std::string> own, SecurityOptions security,
               std::shared_ptr<grpc::ChannelCredentials> credentials);

  RemoteWorker MakeWorker(const std::string& address) const;

  const std::vector<std::string> own_;
  const SecurityOptions security_;
  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  const std::unique_ptr<RemoteFusionWorkers> workers_;
};

// Looks into the directory every half minute for workers that other stores offer.
class OfferWatch {
 public:
  // Neither is owned; both must outlive it.
  OfferWatch(StoreWorkers* workers, const map_store::MissionLeases* leases);
  ~OfferWatch();

 private:
  void Run();

  StoreWorkers& workers_;
  const map_store::MissionLeases& leases_;
  absl::Mutex mutex_;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_
