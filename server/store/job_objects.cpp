// What the objects of a job are called.
#include <algorithm>
#include <string>
#include <string_view>

#include "server/store/object_storage.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kDigitsOfJob = 48;

std::string_view ending_of(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::job_body:
      return ".body";
    case ObjectKind::job_end:
      return ".end";
    case ObjectKind::job_reply:
      return ".reply";
    default:
      return ".job";
  }
}

}  // namespace

std::string name_of_job_object(ObjectKind kind, std::string_view id) {
  return std::string(id) + std::string(ending_of(kind));
}

bool is_job_object(std::string_view name) {
  const std::string_view id = name.substr(0, kDigitsOfJob);
  return id.size() == kDigitsOfJob && id.find_first_not_of("0123456789abcdef") == id.npos &&
         std::any_of(kJobObjects.begin(), kJobObjects.end(),
                     [&](ObjectKind kind) { return name.substr(kDigitsOfJob) == ending_of(kind); });
}

}  // namespace geodesic::server
