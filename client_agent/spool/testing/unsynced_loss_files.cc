#include "client_agent/spool/testing/unsynced_loss_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;

std::string RemovedOf(const std::string& ledger) { return ledger + ".removed"; }

class UnsyncedLossFiles final : public SpoolFiles {
 public:
  UnsyncedLossFiles(std::unique_ptr<SpoolFiles> files, fs::path folder, const std::string& ledger)
      : files_(std::move(files)),
        folder_(std::move(folder)),
        removed_(RemovedOf(ledger)),
        ledger_(ledger, std::ios::app) {}

  absl::StatusOr<std::vector<std::string>> List() override { return files_->List(); }
  absl::StatusOr<uint64_t> Size(const std::string& name) override { return files_->Size(name); }
  absl::StatusOr<std::string> Read(const std::string& name, uint64_t offset,
                                   size_t bytes) override {
    return files_->Read(name, offset, bytes);
  }
  absl::Status Append(const std::string& name, absl::string_view bytes) override {
    return files_->Append(name, bytes);
  }
  absl::Status Truncate(const std::string& name, uint64_t size) override {
    return files_->Truncate(name, size);
  }
  absl::Status Sync(const std::string& name) override {
    // What is appended meanwhile may be left out.
    ASSIGN_OR_RETURN(const uint64_t size, files_->Size(name));
    RETURN_IF_ERROR(files_->Sync(name));
    absl::MutexLock lock(&mutex_);
    ledger_ << name << ' ' << size << std::endl;
    return absl::OkStatus();
  }
  absl::Status Remove(const std::string& name) override {
    std::error_code error;
    fs::create_hard_link(folder_ / name, removed_ / name, error);
    return files_->Remove(name);
  }

 private:
  const std::unique_ptr<SpoolFiles> files_;
  const fs::path folder_;
  const fs::path removed_;
  absl::Mutex mutex_;
  std::ofstream ledger_ ABSL_GUARDED_BY(mutex_);
};

std::map<std::string, uint64_t> ReadLedger(const std::string& ledger) {
  std::map<std::string, uint64_t> synced;
  std::ifstream file(ledger);
  std::string name;
  uint64_t size = 0;
  while (file >> name >> size) synced[name] = size;
  return synced;
}

// Returns how many bytes are lost.
uint64_t CutFile(const fs::path& file, uint64_t synced, std::mt19937& random) {
  const uint64_t size = fs::file_size(file);
  const uint64_t unsynced = size - std::min(synced, size);
  const uint64_t kept = size - unsynced + (random() % 2 == 0 ? 0 : random() % (unsynced + 1));
  fs::resize_file(file, kept);
  // The file may have got its length and not its bytes.
  if (kept < size && random() % 4 == 0) fs::resize_file(file, size);
  if (fs::file_size(file) == 0) fs::remove(file);
  return size - kept;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SpoolFiles>> OpenUnsyncedLossFolder(const std::string& folder,
                                                                   const std::string& ledger) {
  ASSIGN_OR_RETURN(std::unique_ptr<SpoolFiles> files, OpenSpoolFolder(folder));
  std::error_code error;
  fs::create_directories(RemovedOf(ledger), error);
  if (error) return absl::UnavailableError(absl::StrCat(ledger, ": ", error.message()));
  return std::make_unique<UnsyncedLossFiles>(std::move(files), folder, ledger);
}

PowerCutLoss CutPower(const std::string& folder, const std::string& ledger, std::mt19937& random) {
  std::map<std::string, uint64_t> synced = ReadLedger(ledger);
  PowerCutLoss loss;
  for (const auto& removed : fs::directory_iterator(RemovedOf(ledger))) {
    const fs::path back = fs::path(folder) / removed.path().filename();
    if (random() % 2 == 0 || fs::exists(back)) continue;
    fs::copy_file(removed.path(), back);
    ++loss.came_back;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".spool") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    loss.lost_bytes += CutFile(file, synced[file.filename().string()], random);
  }
  fs::remove_all(RemovedOf(ledger));
  fs::remove(ledger);
  return loss;
}

}  // namespace corbslam::client_agent
