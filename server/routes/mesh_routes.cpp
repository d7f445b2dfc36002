// The routes of meshes themselves: upload, list, read, prepare, delete.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "proto/wire/import_options.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/mesh_name.h"
#include "proto/wire/parameters.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/http/content_disposition.h"
#include "server/http/entity_tag.h"
#include "server/http/multipart.h"
#include "server/http/problem.h"
#include "server/reply/encode_reply.h"
#include "server/routes/call.h"
#include "server/routes/routes.h"
#include "server/store/mesh_store.h"

namespace geodesic::server {
namespace {

constexpr std::uint64_t kPageDefault = 100;
constexpr std::uint64_t kPageMost = 1000;
// A page ends behind the mesh that takes it over this.
constexpr std::size_t kPageBytes = std::size_t{1} << 20;

std::string_view media_type_of(std::string_view format) {
  if (format == "glb") return "model/gltf-binary";
  if (format == "gltf") return "model/gltf+json";
  if (format == "obj") return "model/obj";
  if (format == "stl") return "model/stl";
  return "application/octet-stream";
}

// Whether it may be so of every mesh.
bool is_of_the_store(ErrorCode code) {
  return code == ServiceCode::store_failed || code == ServiceCode::store_unavailable;
}

// What the file is called that is uploaded: by the header, else by the form that it came in. Empty
// where neither says so, or where that is no name.
std::string name_of_file(const HttpRequest& request, const std::string& in_form) {
  const std::string* disposition = request.header("Content-Disposition");
  const auto in_header =
      disposition != nullptr ? file_name_in_disposition(*disposition) : std::nullopt;
  std::string name = in_header ? *in_header : without_folders(in_form);
  return proto::is_mesh_name(name) ? name : std::string();
}

// What a list says of a mesh that cannot be described, and why not: the others still can.
std::string undescribed(const std::string& id, const Error& error, const HttpRequest& request) {
  return R"({"id":")" + id + R"(","problem":)" +
         to_problem_json(error, request, 0, request.base_path + "/v1/meshes/" + id) + "}";
}

}  // namespace

HttpResponse Routes::one_mesh(Call& call) {
  call.id = std::string(call.segments[2]);
  call.route = "/v1/meshes/{id}";
  const std::string_view action = call.segments.size() == 4 ? call.segments[3] : "";
  const auto plain = [&](HttpResponse (Routes::*reply)(Call&)) {
    const auto none = call.check_no_parameters();
    return none ? (this->*reply)(call) : call.problem(none.error());
  };
  if (call.segments.size() == 3) {
    if (call.is("GET")) return plain(&Routes::mesh_metadata);
    if (call.is("PUT")) return add_mesh(call);
    if (call.is("PATCH")) return plain(&Routes::rename_mesh);
    if (call.is("DELETE")) return plain(&Routes::delete_mesh);
    return call.not_allowed("GET, HEAD, PUT, PATCH, DELETE");
  }
  constexpr std::array<std::string_view, 4> kOthers{"source", "geometry", "prepare", "batch"};
  if (!is_query(action) && std::find(kOthers.begin(), kOthers.end(), action) == kOthers.end()) {
    return call.problem(ServiceCode::route_unknown, "a mesh has nothing of this name");
  }
  call.route += "/" + std::string(action);
  if (action == "source")
    return call.is("GET") ? plain(&Routes::mesh_source) : call.not_allowed("GET, HEAD");
  if (action == "geometry") {
    return call.is("GET") ? mesh_geometry(call) : call.not_allowed("GET, HEAD");
  }
  if (action == "prepare")
    return call.is("POST") ? plain(&Routes::prepare_mesh) : call.not_allowed("POST");
  if (action == "batch") return call.is("POST") ? batch(call) : call.not_allowed("POST");
  if (!call.is("GET") && !call.is("POST")) return call.not_allowed("GET, HEAD, POST");
  return query(call, action);
}

HttpResponse Routes::add_mesh(Call& call) {
  auto parameters = proto::Parameters::from_query(call.request.query);
  const auto options = proto::read_import_options(parameters);
  if (!options) return call.problem(options.error());
  const auto name = proto::read_mesh_name(parameters);
  if (!name) return call.problem(name.error());
  if (auto known = parameters.check_all_known(); !known) return call.problem(known.error());
  const auto in_form = join_parts(call);
  if (!in_form) return call.problem(in_form.error());
  if (call.is("PUT")) {
    if (const auto own = check_own_digest(call, *options); !own) return call.problem(own.error());
  }
  const auto upload = catalog_.add(std::move(call.request.body), *options, call.request.caller,
                                   name->value_or(name_of_file(call.request, *in_form)));
  if (!upload) return call.problem(upload.error());
  HttpResponse response = described(call, upload->metadata, upload->created ? 201 : 200);
  if (response.status < 300)
    response.set_header("Location", call.request.base_path + "/v1/meshes/" + upload->id);
  return response;
}

// Returns what the form calls its file; empty where there is no form.
Result<std::string> Routes::join_parts(Call& call) {
  const std::string* type = call.request.header("Content-Type");
  if (type == nullptr || !is_multipart(*type)) return std::string();
  const auto boundary = multipart_boundary(*type);
  if (!boundary) {
    return fail(InputCode::bad_syntax, "the content type has no boundary", "Content-Type");
  }
  auto file = catalog_.file_of_form(call.request.body, *boundary, call.request.caller);
  if (!file) return fail(std::move(file.error()));
  call.request.body = std::move(file->bytes);
  return std::move(file->name);
}

// A mesh is put under the digest of its bytes, or under the whole id that the options
// give it.
Result<void> Routes::check_own_digest(const Call& call, const proto::ImportOptions& options) {
  if (!is_mesh_id(call.id)) {
    return fail(ServiceCode::digest_mismatch,
                "a mesh is put under the SHA-256 of its bytes, in lower-case hexadecimal");
  }
  const std::string digest = sha256_hex(call.request.body);
  if (digest != source_digest(call.id)) {
    return fail(ServiceCode::digest_mismatch, "the bytes have another SHA-256 than the URL");
  }
  if (has_options(call.id) && call.id != mesh_id(digest, proto::canonical_text(options))) {
    return fail(ServiceCode::digest_mismatch, "the options have another digest than the URL");
  }
  return {};
}

HttpResponse Routes::list_meshes(Call& call) {
  auto parameters = proto::Parameters::from_query(call.request.query);
  const auto limit = parameters.whole("limit");
  if (!limit) return call.problem(limit.error());
  const auto cursor = parameters.text("cursor");
  if (!cursor) return call.problem(cursor.error());
  if (auto known = parameters.check_all_known(); !known) return call.problem(known.error());
  const std::uint64_t count = limit->value_or(kPageDefault);
  if (count < 1 || count > kPageMost) {
    return call.problem(Error{ErrorCode::value_out_of_range, "a page has 1 to 1000 meshes", "limit",
                              kPageMost, count});
  }
  if (*cursor && !is_mesh_id(**cursor)) {
    return call.problem(
        Error{InputCode::bad_syntax, "this is no cursor of ours", "cursor", {}, {}});
  }
  const auto listed = catalog_.list(cursor->value_or(""), count + 1);
  if (!listed) {
    const auto works = catalog_.check_store();
    return call.problem(works ? listed.error() : works.error());
  }
  const std::vector<std::string>& ids = *listed;
  std::string page = "{\"meshes\":[";
  std::string others;  // that cannot be described
  bool all_for_the_store = true;
  bool first = true;
  std::size_t told = 0;  // of the ids
  while (told < std::min<std::size_t>(ids.size(), count)) {
    if (page.size() + others.size() > kPageBytes) break;
    const std::size_t i = told++;
    if (call.request.caller()) return call.problem(call.request.caller.why_stopped());
    const auto metadata = catalog_.metadata(ids[i], call.request.caller);
    if (!metadata && metadata.error().code == ServiceCode::mesh_unknown) continue;  // just deleted
    if (!metadata) {
      all_for_the_store = all_for_the_store && is_of_the_store(metadata.error().code);
      if (!others.empty()) others += ',';
      others += undescribed(ids[i], metadata.error(), call.request);
      continue;
    }
    if (!first) page += ',';
    first = false;
    page += *metadata;
  }
  if (first && !others.empty() && all_for_the_store) {
    if (auto works = catalog_.check_store(); !works) return call.problem(works.error());
  }
  if (!others.empty()) page += "],\"undescribed\":[" + others;
  page += "],\"next\":";
  page += told < ids.size() ? "\"" + ids[told - 1] + "\"" : "null";
  page += "}";
  return described(call, std::move(page));
}

// What is told of meshes, counted like any large reply.
HttpResponse Routes::described(const Call& call, std::string json, int status) {
  constexpr std::size_t kLittle = std::size_t{64} << 10;
  if (json.size() <= kLittle) return json_reply(std::move(json), status);
  auto reserved = reply_budget_.reserve(json.size(), call.request.caller.client);
  if (!reserved) return call.problem(reserved.error());
  HttpResponse response = json_reply(std::move(json), status);
  response.reserved = std::move(*reserved);
  return response;
}

HttpResponse Routes::mesh_metadata(Call& call) {
  auto metadata = catalog_.metadata(call.id, call.request.caller);
  return metadata ? described(call, std::move(*metadata)) : call.problem(metadata.error());
}

HttpResponse Routes::mesh_source(Call& call) {
  const auto metadata = catalog_.metadata(call.id, call.request.caller);
  if (!metadata) return call.problem(metadata.error());
  const auto description = nlohmann::ordered_json::parse(*metadata, nullptr, false);
  // The id is a digest of the bytes.
  const std::string tag = "\"" + call.id + "\"";
  HttpResponse response;
  if (has_already(call.request, tag)) {
    response = not_modified(tag);
  } else {
    auto sent = source_reply(call, description.value("bytes", std::uint64_t{0}));
    if (!sent) return call.problem(sent.error());
    response = std::move(*sent);
    response.content_type = media_type_of(description.value("format", ""));
    response.set_header("ETag", tag);
  }
  response.set_header("Cache-Control", access_.audience() + ", max-age=31536000, immutable");
  response.set_header("X-Content-Type-Options", "nosniff");
  return response;
}

// As it is read from its file; or, from a store without files, in memory of its own.
Result<HttpResponse> Routes::source_reply(const Call& call, std::uint64_t expected_bytes) {
  HttpResponse response;
  auto file = catalog_.source_file(call.id, call.request.caller);
  if (!file) return fail(std::move(file.error()));
  response.file = std::move(*file);
  if (response.file) return response;
  auto reserved = reply_budget_.reserve(expected_bytes, call.request.caller.client);
  if (!reserved) return fail(std::move(reserved.error()));
  auto bytes = catalog_.source(call.id);
  if (!bytes) return fail(std::move(bytes.error()));
  response.set_body(std::move(*bytes), {});
  response.reserved = std::move(*reserved);
  return response;
}

HttpResponse Routes::prepare_mesh(Call& call) {
  if (!call.request.body.empty()) {
    return call.problem(Error{InputCode::bad_syntax, "this call takes no body", "body", {}, {}});
  }
  const auto adjacency = catalog_.adjacency(call.id, call.request.caller);
  if (!adjacency) return call.problem(adjacency.error());
  return mesh_metadata(call);
}

HttpResponse Routes::rename_mesh(Call& call) {
  const auto memory = memory_for_json(call.request.body.size(), call.request.caller);
  if (!memory) return call.problem(memory.error());
  auto parameters = proto::Parameters::from_json(call.request.body);
  if (!parameters) return call.problem(parameters.error());
  const auto name = proto::read_mesh_name(*parameters);
  if (!name) return call.problem(name.error());
  if (auto known = parameters->check_all_known(); !known) return call.problem(known.error());
  if (!*name) {
    return call.problem(Error{
        InputCode::bad_syntax, "a name is wanted; an empty one takes it away", "name", {}, {}});
  }
  auto metadata = catalog_.rename(call.id, **name, call.request.caller);
  return metadata ? described(call, std::move(*metadata)) : call.problem(metadata.error());
}

HttpResponse Routes::delete_mesh(Call& call) {
  queries_.forget(call.id);
  if (const auto removed = catalog_.remove(call.id); !removed) return call.problem(removed.error());
  replies_.erase_prefix(call.id);
  queries_.forget(call.id);  // what a query under way has put back meanwhile
  HttpResponse response;
  response.status = 204;
  return response;
}

}  // namespace geodesic::server
