// The fixture of the tests that every journal passes (journal_conformance_test.cc). A journal's own
// test program has that file among its sources, and instantiates the suite with its kind of place.
#ifndef CORBSLAM_MAP_STORE_TESTING_JOURNAL_CONFORMANCE_H_
#define CORBSLAM_MAP_STORE_TESTING_JOURNAL_CONFORMANCE_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/records/journal.h"
#include "map_store/store/map_store.h"

namespace corbslam::testing {

// Where a journal's missions are when no process has it open. It is made empty.
class JournalPlace {
 public:
  virtual ~JournalPlace() = default;

  // Opens the journal. The one that was opened before must be gone.
  virtual absl::StatusOr<std::unique_ptr<map_store::Journal>> Open(
      uint64_t min_bytes_between_snapshots) = 0;
  // Keeps only what is durable at this moment, as if the power went; the open journal is of no use
  // any more, and is destroyed after this.
  virtual void LosePower() {}
  // Spoils the bytes of a record of the mission; no journal is open.
  virtual void Spoil(const std::string& mission) { (void)mission; }
};

struct JournalKind {
  std::string name;  // Of letters.
  std::function<std::unique_ptr<JournalPlace>()> make_place;
};

class JournalConformance : public ::testing::TestWithParam<JournalKind> {
 protected:
  static constexpr char kMission[] = "m";
  static constexpr uint64_t kNoSnapshots = uint64_t{1} << 40;

  JournalConformance() : place_(GetParam().make_place()) {}

  // Opens the journal; one that is open ends in an orderly way first.
  void Open(uint64_t min_bytes_between_snapshots = kNoSnapshots);
  // Appends the records and waits until they are durable; returns the last one's position.
  map_store::Journal::Position Write(const std::string& mission,
                                     const std::vector<map_store::JournalRecord>& records);
  // Returns what a replay shows, a line for each call, and the position that it returned. Two
  // replays that show the same have the same lines.
  std::vector<std::string> Replay(const std::string& mission,
                                  map_store::Journal::Replay replay = {}) const;
  // Returns what a replay of these records would show.
  static std::vector<std::string> LinesOf(const std::vector<map_store::JournalRecord>& records);

  const std::unique_ptr<JournalPlace> place_;
  std::unique_ptr<map_store::Journal> journal_;
};

// What is true of journals that keep records (Journal::KeepsRecords).
class DurableJournalConformance : public JournalConformance {};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_JOURNAL_CONFORMANCE_H_
