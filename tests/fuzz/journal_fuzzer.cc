// What a map store finds in its journal: a snapshot, records and features of arbitrary bytes. It
// refuses them, or has a mission that works, and that it can write and read again.
//
// The first byte's lowest bit: the second message is a snapshot. The first message: the features of
// every keyframe. The others: records.
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "map_store/testing/byte_journal.h"
#include "map_store/testing/recover_undamaged.h"
#include "tests/fuzz/agreeable_worker.h"
#include "tests/fuzz/live_store.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using map_store::MapStore;

namespace {

using testing::ByteJournal;
using testing::JournalBytes;

std::shared_ptr<JournalBytes> ReadInput(uint8_t kind, absl::string_view input) {
  auto bytes = std::make_shared<JournalBytes>();
  bytes->other_features = std::string(TakeMessage(input));
  if ((kind & 1) != 0) bytes->snapshot = std::string(TakeMessage(input));
  while (!input.empty()) bytes->records.emplace_back(TakeMessage(input));
  return bytes;
}

absl::StatusOr<std::unique_ptr<MapStore>> Open(const std::shared_ptr<JournalBytes>& bytes,
                                               FusionWorker* worker) {
  auto store =
      std::make_unique<MapStore>(LiveStoreOptions(), nullptr, std::make_unique<ByteJournal>(bytes),
                                 worker, [] { return absl::UnixEpoch(); });
  const absl::Status recovered = testing::RecoverUndamaged(*store);
  if (!recovered.ok()) return recovered;
  return store;
}

void MustOpen(const std::shared_ptr<JournalBytes>& bytes, FusionWorker* worker) {
  const auto again = Open(bytes, worker);
  if (again.ok()) return;
  std::fprintf(stderr, "what the store wrote can't be read: %s\n",
               again.status().ToString().c_str());
  std::abort();
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  if (size == 0) return 0;
  AgreeableWorker worker;
  const std::shared_ptr<JournalBytes> bytes = ReadInput(data[0], AsText(data + 1, size - 1));
  auto store = Open(bytes, &worker);
  if (!store.ok()) return 0;
  LookAtEverything(**store);
  store->reset();
  MustOpen(bytes, &worker);
  // The store must also open from a snapshot.
  bytes->wants_snapshot = true;
  store = Open(bytes, &worker);
  if (!store.ok()) std::abort();
  (*store)->RunFusionUntilIdle(bytes->mission).IgnoreError();
  store->reset();
  MustOpen(bytes, &worker);
  return 0;
}
