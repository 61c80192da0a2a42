#include "services/viewer/page_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "slam/util/checksum.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kMaxFileBytes = 16u << 20;

std::string ContentType(const std::string& name) {
  static const auto& types = *new std::map<std::string, std::string>{
      {".html", "text/html; charset=utf-8"}, {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},   {".svg", "image/svg+xml"},
      {".json", "application/json"},         {".png", "image/png"},
      {".map", "application/json"},          {".txt", "text/plain; charset=utf-8"}};
  const auto type = types.find(fs::path(name).extension().string());
  return type == types.end() ? "application/octet-stream" : type->second;
}

absl::StatusOr<std::string> ReadWhole(const fs::path& path) {
  std::error_code error;
  const uintmax_t size = fs::file_size(path, error);
  if (error || size > kMaxFileBytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        path.string(), error
                           ? absl::StrCat(": ", error.message())
                           : absl::StrCat(" has ", size, " bytes; the limit is ", kMaxFileBytes)));
  }
  std::ifstream in(path, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad() || content.size() != size) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), " can't be read"));
  }
  return content;
}

WebResponse Missing(const std::string& path) {
  return TextResponse(404, absl::StrCat("there is no ", path.substr(0, 200)));
}

}  // namespace

absl::StatusOr<PageFiles> PageFiles::Load(const std::string& folder) {
  PageFiles page;
  std::error_code error;
  std::map<std::string, std::shared_ptr<const std::string>> compressed;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (!it->is_regular_file()) continue;
    std::string name = absl::StrCat("/", fs::relative(it->path(), folder).string());
    ASSIGN_OR_RETURN(std::string content, ReadWhole(it->path()));
    auto shared = std::make_shared<const std::string>(std::move(content));
    if (absl::EndsWith(name, ".gz")) {
      compressed[std::string(absl::StripSuffix(name, ".gz"))] = std::move(shared);
      continue;
    }
    page.files_[name] = {ContentType(name),
                         absl::StrFormat("\"%08x-%d\"", ExtendCrc32c(0, *shared), shared->size()),
                         std::move(shared), nullptr};
  }
  if (error || !page.files_.contains("/index.html")) {
    return absl::NotFoundError(absl::StrCat(
        folder, " has no page (index.html)", error ? absl::StrCat(": ", error.message()) : "",
        "; it is built where node and npm are, or name its folder with --page"));
  }
  for (auto& [name, file] : page.files_) {
    if (const auto it = compressed.find(name); it != compressed.end()) file.gzip = it->second;
  }
  page.files_["/"] = page.files_["/index.html"];
  return page;
}

WebResponse PageFiles::Answer(const WebRequest& request) const {
  const auto it = files_.find(request.path);
  if (it == files_.end()) return Missing(request.path);
  const File& file = it->second;
  WebResponse response;
  response.content_type = file.content_type;
  response.headers["ETag"] = file.tag;
  // The page is small: it asks each time whether it has changed.
  response.headers["Cache-Control"] = "no-cache";
  response.headers["Vary"] = "Accept-Encoding";
  if (request.if_none_match == file.tag) {
    response.status = 304;
  } else if (request.takes_gzip && file.gzip != nullptr) {
    response.body = file.gzip;
    response.headers["Content-Encoding"] = "gzip";
  } else {
    response.body = file.plain;
  }
  return response;
}

}  // namespace corbslam::services
