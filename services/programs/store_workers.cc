#include "services/programs/store_workers.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_join.h"
#include "services/client/reachability/failure_explainer.h"
#include "services/client/remote/channel.h"
#include "services/programs/offered_workers.h"
#include "services/programs/store_address.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kBetweenLooks = absl::Seconds(30);

}  // namespace

StoreWorkers::StoreWorkers(std::vector<std::string> own, SecurityOptions security,
                           std::shared_ptr<grpc::ChannelCredentials> credentials)
    : own_(std::move(own)),
      security_(std::move(security)),
      credentials_(std::move(credentials)),
      workers_(MakeRemoteFusionWorkers({})) {
  UseOffered({});
}

absl::StatusOr<std::unique_ptr<StoreWorkers>> StoreWorkers::Connect(
    std::vector<std::string> addresses, const SecurityOptions& security) {
  ASSIGN_OR_RETURN(auto credentials, MakeChannelCredentials(security));
  return std::unique_ptr<StoreWorkers>(
      new StoreWorkers(std::move(addresses), security, std::move(credentials)));
}

RemoteWorker StoreWorkers::MakeWorker(const std::string& address) const {
  auto explainer =
      std::make_shared<FailureExplainer>(ServerTarget{address, kFusionWorkerService, security_});
  return {address, MakeChannel(address, credentials_),
          [explainer](const absl::Status& seen) { return explainer->Explain(seen); }};
}

void StoreWorkers::UseOffered(const std::set<std::string>& offered) {
  std::vector<RemoteWorker> workers;
  for (const std::string& address : own_) workers.push_back(MakeWorker(address));
  // Of equals the first is asked: for each store another one, behind its own.
  const auto begin = own_.empty() ? offered.begin() : offered.upper_bound(own_.front());
  for (auto it = begin; it != offered.end(); ++it) workers.push_back(MakeWorker(*it));
  for (auto it = offered.begin(); it != begin; ++it) workers.push_back(MakeWorker(*it));
  workers_->Use(std::move(workers));
}

OfferWatch::OfferWatch(StoreWorkers* workers, const map_store::MissionLeases* leases)
    : workers_(*workers), leases_(*leases) {
  thread_ = StartThread("offer watch", [this] { Run(); });
}

OfferWatch::~OfferWatch() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
  }
  thread_.join();
}

void OfferWatch::Run() {
  std::set<std::string> known;
  do {
    const absl::StatusOr<std::vector<map_store::DirectoryStore>> stores = leases_.ListStores();
    // Without the directory, those that were known go on.
    if (!stores.ok()) continue;
    const std::set<std::string> offered = OfferedWorkers(*stores, workers_.own(), NameOfMachine());
    if (offered == known) continue;
    LOG(INFO) << "other stores' fusion workers: " << absl::StrJoin(offered, ", ");
    workers_.UseOffered(offered);
    known = offered;
  } while ([this] {
    absl::MutexLock lock(&mutex_);
    return !mutex_.AwaitWithTimeout(absl::Condition(&stops_), kBetweenLooks);
  }());
}

}  // namespace corbslam::services
