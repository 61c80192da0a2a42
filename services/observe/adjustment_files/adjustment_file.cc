#include "services/observe/adjustment_files/adjustment_file.h"

#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>

#include <cstdio>
#include <fstream>
#include <functional>

#include "absl/strings/str_cat.h"
#include "services/convert/errors.h"
#include "services/convert/work/work.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using Message = v1::AdjustBundleRequest;
using Reader = WorkReader<AdjustBundleRequestReader, v1::MapChunk>;

// Reads all messages up to the end.
absl::Status ReadMessages(std::istream& file, Reader& reader) {
  google::protobuf::io::IstreamInputStream stream(&file);
  while (!reader.ended()) {
    Message message;
    if (!google::protobuf::util::ParseDelimitedFromZeroCopyStream(&message, &stream, nullptr)) {
      return absl::InvalidArgumentError("it is cut short, or holds something else");
    }
    RETURN_IF_ERROR(reader.Add(message));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status WriteAdjustment(const AdjustBundleRequest& request, const std::string& path) {
  // The name ends with ".part" until the file is whole: whoever lists the folder finds whole ones
  // only.
  const std::string unfinished = path + ".part";
  std::ofstream file(unfinished, std::ios::binary);
  const bool sent = WriteWork<Message>(
      request, std::function<bool(Message)>([&file](const Message& message) {
        return google::protobuf::util::SerializeDelimitedToOstream(message, &file);
      }));
  file.close();
  if (sent && file && std::rename(unfinished.c_str(), path.c_str()) == 0) return absl::OkStatus();
  std::remove(unfinished.c_str());
  return absl::UnavailableError(absl::StrCat(path, ": can't be written"));
}

absl::StatusOr<AdjustBundleRequest> ReadAdjustment(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat(path, ": can't be opened"));
  Reader reader;
  const absl::Status read = ReadMessages(file, reader);
  if (!read.ok()) return Locate(read, path);
  absl::StatusOr<AdjustBundleRequest> request = reader.Finish();
  if (!request.ok()) return Locate(request.status(), path);
  return request;
}

}  // namespace corbslam::services
