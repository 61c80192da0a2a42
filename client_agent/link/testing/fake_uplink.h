// Simulates a map store at the other end of an uplink, for tests of the link to it.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_TESTING_FAKE_UPLINK_H_
#define CORBSLAM_CLIENT_AGENT_LINK_TESTING_FAKE_UPLINK_H_

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/upload/batch_allowance.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// A map store that forgets nothing and can be made to fail. It answers from inside the calls.
class FakeUplink : public Uplink {
 public:
  void Open(const SessionRequest& request, UplinkListener* listener) override {
    requests.push_back(request);
    listener_ = listener;
    if (!refusal.ok()) return listener->OnSessionClosed(refusal);
    if (!reachable) return listener->OnSessionClosed(absl::UnavailableError("no route"));
    open = true;
    SessionGrant grant;
    grant.capabilities = capabilities;
    grant.mission_uid = mission_uid;
    for (const LocalMapId& id : request.local_maps) {
      grant.acknowledged.push_back({id, stored[id].size()});
    }
    listener->OnSessionOpened(grant);
  }
  bool Send(const MapUpdateBatch& batch) override {
    if (!open) return false;
    if (!accept) return true;
    bytes += static_cast<uint64_t>(wire_factor * static_cast<double>(EstimateWireBytes(batch)));
    auto& batches = stored[batch.local_map];
    if (batch.number == batches.size() + 1) batches.push_back(batch);
    EXPECT_LE(batch.number, batches.size()) << "a batch is missing";
    if (acknowledge) listener_->OnAcknowledged({batch.local_map, batches.size()});
    return true;
  }
  bool SendLocalised(const LocalisedFrames& /*localised*/) override { return false; }
  bool SendPicture(const KeyframePicture& picture) override {
    if (!open || !takes_pictures) return false;
    bytes += picture.jpeg.size();
    pictures.push_back(picture);
    return true;
  }
  bool SendReport(const AgentReport& report) override {
    if (open) reports.push_back(report);
    return open;
  }
  void Break(const absl::Status& reason) {
    open = false;
    listener_->OnSessionClosed(reason);
  }
  void Share(SharedUpdate update) { listener_->OnShared(std::move(update)); }
  void AskForExactPlaces() { listener_->OnExactPlacesWanted(); }
  void Close() override { open = false; }
  void PauseReading() override { paused = true; }
  void ResumeReading() override { paused = false; }
  uint64_t bytes_up() const override { return bytes; }
  uint64_t bytes_waiting() const override {
    if (when_asked != nullptr) when_asked();
    return waiting;
  }
  uint64_t bytes_down() const override { return 0; }

  std::atomic<bool> reachable = true;
  bool acknowledge = true;
  // False: the transport has no room for pictures.
  bool takes_pictures = true;
  std::vector<KeyframePicture> pictures;
  // False: what is sent is not stored.
  bool accept = true;
  // Why sessions are refused; OK: they are not.
  absl::Status refusal;
  Capabilities capabilities = {.points_follow = true};
  std::string mission_uid;
  // What a batch takes, as a multiple of its estimate.
  double wire_factor = 1;
  std::atomic<uint64_t> bytes = 0;
  std::atomic<uint64_t> waiting = 0;
  // Called when the link asks what waits, as it does before it takes batches; null: nobody is.
  std::function<void()> when_asked;
  bool open = false;
  // True: the link does not read, so that a store would share nothing now.
  bool paused = false;
  std::vector<SessionRequest> requests;
  std::map<LocalMapId, std::vector<MapUpdateBatch>> stored;
  std::vector<AgentReport> reports;

 protected:
  void Keep(const LocalisedKept& kept) { listener_->OnLocalisedKept(kept); }

 private:
  UplinkListener* listener_ = nullptr;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_TESTING_FAKE_UPLINK_H_
