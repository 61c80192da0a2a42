// Has the journal on PostgreSQL pass the tests of any journal.
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/testing/journal_conformance.h"
#include "map_store/testing/postgres_server.h"

namespace corbslam::map_store {
namespace {

using testing::DurableJournalConformance;
using testing::JournalConformance;
using testing::JournalKind;
using testing::JournalPlace;
using testing::PostgresServer;

class DatabasePlace : public JournalPlace {
 public:
  absl::StatusOr<std::unique_ptr<Journal>> Open(uint64_t min_bytes_between_snapshots) override {
    if (is_down_) server_.Start();
    is_down_ = false;
    auto journal =
        PostgresJournal::Open({.uri = server_.Uri(database_),
                               .min_bytes_between_snapshots = min_bytes_between_snapshots});
    if (!journal.ok()) return journal.status();
    return *std::move(journal);
  }
  void LosePower() override {
    server_.Kill();
    is_down_ = true;
  }
  void Spoil(const std::string& mission) override {
    server_.Ask(database_,
                absl::StrCat("UPDATE corbslam.records SET bytes = set_byte(bytes, 9, 256 - "
                             "greatest(1, get_byte(bytes, 9))) WHERE position = 5 AND mission_id ="
                             " (SELECT mission_id FROM corbslam.missions WHERE name = '",
                             mission, "')"));
  }

 private:
  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
  bool is_down_ = false;
};

const JournalKind kServer = {"Server", [] { return std::make_unique<DatabasePlace>(); }};

INSTANTIATE_TEST_SUITE_P(Postgres, JournalConformance, ::testing::Values(kServer),
                         [](const auto& info) { return info.param.name; });
INSTANTIATE_TEST_SUITE_P(Postgres, DurableJournalConformance, ::testing::Values(kServer),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace corbslam::map_store
