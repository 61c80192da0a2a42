// Stands for the uplink of a robot that has no map store, but a spool for one.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_NO_UPLINK_H_
#define CORBSLAM_CLIENT_AGENT_LINK_NO_UPLINK_H_

#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// No session ever stands, and none fails.
class NoUplink : public Uplink {
 public:
  void Open(const SessionRequest& /*request*/, UplinkListener* /*listener*/) override {}
  bool Send(const MapUpdateBatch& /*batch*/) override { return false; }
  bool SendLocalised(const LocalisedFrames& /*localised*/) override { return false; }
  bool SendPicture(const KeyframePicture& /*picture*/) override { return false; }
  bool SendReport(const AgentReport& /*report*/) override { return false; }
  void Close() override {}
  uint64_t bytes_up() const override { return 0; }
  uint64_t bytes_down() const override { return 0; }
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_NO_UPLINK_H_
