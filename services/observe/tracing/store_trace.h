// Traces the map store's part of the keyframes' way.
#ifndef CORBSLAM_SERVICES_OBSERVE_TRACING_STORE_TRACE_H_
#define CORBSLAM_SERVICES_OBSERVE_TRACING_STORE_TRACE_H_

#include <map>
#include <set>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/map_store_service/streams/sync_observer.h"
#include "services/observe/observed_journal.h"
#include "services/observe/tracing/trace_file.h"

namespace corbslam::services {

// Writes the store's events. It hears of placing and adjusting from the journal, when a revision is
// committed. Thread-safe.
class StoreTrace : public SyncObserver, public JournalObserver {
 public:
  // `file` is not owned and must outlive it.
  explicit StoreTrace(TraceFile* file) : file_(*file) {}

  void OnBatch(const SessionAgent& agent, const MapUpdateBatch& batch) override;
  void OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration took,
                 const absl::Status& status) override;
  void OnShared(const SessionAgent& agent, const SharedUpdate& update) override;

  void OnAppended(absl::string_view mission, const map_store::JournalRecord& record,
                  absl::Duration took, const absl::Status& status) override;
  void OnSynced(absl::Duration, const absl::Status&) override {}
  void OnSnapshot(absl::Duration, const absl::Status&) override {}
  void OnChecked(const absl::Status&) override {}
  void OnDeleted(absl::string_view mission) override;

 private:
  // What the keyframes of one mission had already, so that each event is written once.
  struct Seen {
    std::map<LocalMapId, std::string> owners;
    std::set<KeyframeId> placed;
    std::set<KeyframeId> adjusted;
  };

  void NoteRevision(absl::string_view name, const std::string& mission,
                    const map_store::RevisionPlan& plan, const Seen& seen,
                    std::set<KeyframeId>& once) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  TraceFile& file_;
  absl::Mutex mutex_;
  std::map<std::string, Seen, std::less<>> missions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_TRACING_STORE_TRACE_H_
