// Connects an agent to a map store in the same process, without a thread or a socket: for a
// deterministic run in lockstep.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_DIRECT_UPLINK_H_
#define CORBSLAM_SERVICES_TOOL_RUN_DIRECT_UPLINK_H_

#include <optional>
#include <vector>

#include "map_store/store/map_store.h"
#include "services/convert/features.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// An uplink that does everything on the caller's thread; the listener is called from inside Open,
// Send and DeliverShared. Not thread-safe.
class DirectUplink : public Uplink {
 public:
  // `store` is not owned and outlives this uplink.
  explicit DirectUplink(map_store::MapStore* store) : store_(store) {}
  ~DirectUplink() override { Close(); }

  void Open(const SessionRequest& request, UplinkListener* listener) override;
  bool Send(const MapUpdateBatch& batch) override;
  bool SendLocalised(const LocalisedFrames& localised) override;
  // Agents in lockstep make no pictures.
  bool SendPicture(const KeyframePicture& /*picture*/) override { return false; }
  bool SendReport(const AgentReport& report) override;
  void Close() override;
  // Returns the size of the messages as the wire would carry them.
  uint64_t bytes_up() const override { return bytes_up_; }
  uint64_t bytes_down() const override { return bytes_down_; }

  // Hands the agent everything that the store has for it now.
  void DeliverShared();

 private:
  void End(const absl::Status& reason);

  map_store::MapStore* const store_;
  UplinkListener* listener_ = nullptr;
  std::optional<uint64_t> session_;
  Capabilities agent_understands_;
  Capabilities store_understands_;
  // Cameras that a stream would have named already.
  CameraBook sent_up_;
  CameraBook sent_down_;
  uint64_t bytes_up_ = 0;
  uint64_t bytes_down_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_DIRECT_UPLINK_H_
