#include "services/convert/asked_resource.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "corbslam/v1/access.pb.h"

namespace corbslam::services {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::MethodDescriptor;

const MethodDescriptor* FindMethod(absl::string_view path) {
  constexpr absl::string_view kOurs = "corbslam.";
  if (!absl::ConsumePrefix(&path, "/") || path.substr(0, kOurs.size()) != kOurs) return nullptr;
  const std::pair<std::string, std::string> parts = absl::StrSplit(path, absl::MaxSplits('/', 1));
  const google::protobuf::ServiceDescriptor* service =
      google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(parts.first);
  return service != nullptr ? service->FindMethodByName(parts.second) : nullptr;
}

absl::StatusOr<std::string> ReadText(const Message& message, absl::string_view field) {
  const std::pair<std::string, std::string> parts = absl::StrSplit(field, absl::MaxSplits('.', 1));
  const FieldDescriptor* found = message.GetDescriptor()->FindFieldByName(parts.first);
  const auto wanted =
      parts.second.empty() ? FieldDescriptor::CPPTYPE_STRING : FieldDescriptor::CPPTYPE_MESSAGE;
  if (found == nullptr || found->is_repeated() || found->cpp_type() != wanted) {
    return absl::InternalError(absl::StrCat(message.GetTypeName(), " has no text ", field));
  }
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  if (parts.second.empty()) return reflection.GetString(message, found);
  return ReadText(reflection.GetMessage(message, found), parts.second);
}

std::string ResourceOf(const MethodDescriptor& method, const Message& request) {
  const v1::Access& access = method.options().GetExtension(v1::access);
  if (access.mission_size() == 0) return "";
  return ReadText(request, access.mission(0)).value_or("");
}

}  // namespace corbslam::services
