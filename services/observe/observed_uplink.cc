#include "services/observe/observed_uplink.h"

#include <atomic>
#include <utility>

#include "absl/time/clock.h"

namespace corbslam::services {
namespace {

class ObservedUplink : public Uplink, private UplinkListener {
 public:
  ObservedUplink(Uplink* uplink, std::vector<UplinkObserver*> observers)
      : uplink_(*uplink), observers_(std::move(observers)) {}
  ~ObservedUplink() override { Close(); }

  // An agent has one listener, so that one member keeps it.
  void Open(const SessionRequest& request, UplinkListener* listener) override {
    listener_ = listener;
    for (UplinkObserver* observer : observers_) observer->OnOpening();
    uplink_.Open(request, this);
  }

  bool Send(const MapUpdateBatch& batch) override {
    const absl::Time offered = absl::Now();
    if (!uplink_.Send(batch)) return false;
    for (UplinkObserver* observer : observers_) observer->OnSent(batch, offered);
    return true;
  }

  bool SendLocalised(const LocalisedFrames& localised) override {
    return uplink_.SendLocalised(localised);
  }

  bool SendPicture(const KeyframePicture& picture) override {
    return uplink_.SendPicture(picture);
  }

  bool SendReport(const AgentReport& report) override { return uplink_.SendReport(report); }

  void PauseReading() override { uplink_.PauseReading(); }
  void ResumeReading() override { uplink_.ResumeReading(); }
  void Close() override { uplink_.Close(); }
  uint64_t bytes_up() const override { return uplink_.bytes_up(); }
  uint64_t bytes_waiting() const override { return uplink_.bytes_waiting(); }
  uint64_t bytes_down() const override { return uplink_.bytes_down(); }

 private:
  void OnSessionOpened(const SessionGrant& grant) override {
    for (UplinkObserver* observer : observers_) observer->OnOpened();
    for (const Acknowledgement& acknowledged : grant.acknowledged) NoteAcknowledged(acknowledged);
    listener_.load()->OnSessionOpened(grant);
  }
  void OnAcknowledged(const Acknowledgement& acknowledgement) override {
    NoteAcknowledged(acknowledgement);
    listener_.load()->OnAcknowledged(acknowledgement);
  }
  void OnLocalisedKept(const LocalisedKept& kept) override {
    listener_.load()->OnLocalisedKept(kept);
  }
  void OnShared(SharedUpdate update) override { listener_.load()->OnShared(std::move(update)); }
  void OnExactPlacesWanted() override { listener_.load()->OnExactPlacesWanted(); }
  void OnSessionClosed(const absl::Status& reason) override {
    for (UplinkObserver* observer : observers_) observer->OnClosed(reason);
    listener_.load()->OnSessionClosed(reason);
  }

  void NoteAcknowledged(const Acknowledgement& acknowledgement) {
    for (UplinkObserver* observer : observers_) observer->OnAcknowledged(acknowledgement);
  }

  Uplink& uplink_;
  const std::vector<UplinkObserver*> observers_;
  std::atomic<UplinkListener*> listener_{nullptr};
};

}  // namespace

std::unique_ptr<Uplink> MakeObservedUplink(Uplink* uplink, std::vector<UplinkObserver*> observers) {
  return std::make_unique<ObservedUplink>(uplink, std::move(observers));
}

}  // namespace corbslam::services
